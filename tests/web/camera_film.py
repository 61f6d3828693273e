"""A film for Chromium's fake camera: a picture held before it by a hand that is not quite still."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageFilter

_SIZE = (640, 480)


def write_film(path: Path, pictures: list[Image.Image], frames_each: int = 4) -> None:
    """Write a y4m (YUV 4:2:0, 10 frames a second) that shows each picture for some frames."""
    rng = np.random.default_rng(1)
    with path.open("wb") as film:
        film.write(b"YUV4MPEG2 W%d H%d F10:1 Ip A1:1 C420jpeg\n" % _SIZE)
        for picture in pictures:
            for _ in range(frames_each):
                film.write(b"FRAME\n" + _frame(picture, rng))


def _frame(picture: Image.Image, rng: np.random.Generator) -> bytes:
    """A grey room, the picture askew and a little unsharp in it, and the noise of a small sensor."""
    room = Image.new("RGB", _SIZE, (96, 92, 88))
    held = picture.convert("RGB").resize((430, round(430 * picture.height / picture.width)))
    mask = Image.new("L", held.size, 255).rotate(tilt := float(rng.normal(6.0, 2.0)), expand=True)
    room.paste(held.rotate(tilt, expand=True), (90 + int(rng.integers(-9, 9)), 30), mask)
    seen = np.asarray(room.filter(ImageFilter.GaussianBlur(0.7)), float) * 0.8
    noisy = np.clip(seen + rng.normal(0.0, 5.0, seen.shape), 0.0, 255.0).astype(np.uint8)
    y, cb, cr = Image.fromarray(noisy).convert("YCbCr").split()
    half = (_SIZE[0] // 2, _SIZE[1] // 2)
    return y.tobytes() + cb.resize(half).tobytes() + cr.resize(half).tobytes()
