"""Making a photo safe: what a stranger's file shows is drawn anew, and nothing else of it is kept."""

from __future__ import annotations

import io
import struct

from PIL import Image, ImageOps

from db.photos import Pictures

FORMATS = ("JPEG", "PNG", "WEBP")
MAX_PIXELS = 50_000_000  # more than any phone's camera makes; 150 MB once decoded
_WHOLE_PX, _SMALL_PX = 2048, 320
_QUALITY = 85


class PhotoError(ValueError):
    """The file is no photo that can be kept; the message says why and what to do."""


def drawn_anew(data: bytes) -> tuple[Pictures, tuple[int, int]]:
    """Return a photo upright, as JPEG of at most 2048 and of 320 pixels along its longer side, and its size.

    Position, time, camera, previews, colour profile, text and what follows the picture in the file are gone.
    Of moving pictures the first stays.

    Raises:
        PhotoError: no JPEG, PNG or WebP, damaged, or of too many pixels.
    """
    try:
        with Image.open(io.BytesIO(data), formats=FORMATS) as file:
            if file.width * file.height > MAX_PIXELS:
                text = f"The photo has {file.width} x {file.height} pixels; send one of at most 50 million"
                raise PhotoError(text)
            file.draft("RGB", (_WHOLE_PX, _WHOLE_PX))  # JPEG: decoded no larger than is kept
            upright = ImageOps.exif_transpose(file)
            flat = _on_white(upright)
    except (
        OSError,
        SyntaxError,
        ValueError,
        OverflowError,
        struct.error,
        Image.DecompressionBombError,
    ) as error:
        if isinstance(error, PhotoError):
            raise
        text = "This file is no photo that can be read: send a JPEG, PNG or WebP that is whole"
        raise PhotoError(text) from error
    flat.thumbnail((_WHOLE_PX, _WHOLE_PX), Image.Resampling.LANCZOS)
    small = flat.copy()
    small.thumbnail((_SMALL_PX, _SMALL_PX), Image.Resampling.LANCZOS)
    return Pictures(_jpeg(flat), _jpeg(small)), flat.size


def _on_white(image: Image.Image) -> Image.Image:
    """Return the pixels alone; what is transparent becomes white."""
    if not image.has_transparency_data:
        return _bare(image.convert("RGB"))
    layered = image.convert("RGBA")
    flat = Image.new("RGB", image.size, "white")
    flat.paste(layered, mask=layered.getchannel("A"))
    return flat


def _bare(image: Image.Image) -> Image.Image:
    """Return an image without what its file said beside the pixels."""
    flat = Image.new("RGB", image.size)
    flat.paste(image)
    return flat


def _jpeg(image: Image.Image) -> bytes:
    file = io.BytesIO()
    image.save(file, "JPEG", quality=_QUALITY, optimize=True)
    return file.getvalue()
