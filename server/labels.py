"""Sheets of labels for tags: what a phone scans, what people type, and room to write by hand.

A label is of use when no phone works: it names its tag in large letters, has an arrow to lay north, and lines
for the place, the way out and the next tag.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from urllib.parse import quote, urlsplit

from robots.tags.short_id import short_id

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 2000
_MM = 1.0 / 25.4
_PAPERS = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}
_GRIDS = {2: (1, 2), 4: (2, 2), 8: (2, 4)}  # labels on a sheet: columns, rows
FIT: Mapping[Literal["2", "4", "8"], Literal[2, 4, 8]] = {"2": 2, "4": 4, "8": 8}
_BASE_MM = 74.25  # height of the label that the sizes below are for: eight on A4
_DO = (
    "Touch or scan me: where you are, who is near,\nthe way there. No camera: type the number at\n{site}"
    "\nLay the arrow north. Leave me here.",
    "Berühren oder scannen: wo bin ich, wer ist nah,\nWeg. Ohne Kamera: Nummer eintippen bei\n{site}"
    "\nPfeil nach Norden legen. Nicht wegnehmen.",
)
_LINES = ("Place / Ort", "Way out / Ausgang", "Next tag / Nächste Marke", "Searched / Durchsucht")


class LabelError(ValueError):
    """These labels cannot be made; the message says what to change."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A sheet of labels: its paper, and how many fit on it (2, 4 or 8)."""

    paper: Literal["a4", "letter"] = "a4"
    labels: Literal[2, 4, 8] = 8

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and height of the paper."""
        return _PAPERS[self.paper]


def numbered(first: str, last: str | None = None) -> list[str]:
    """Return the ids from one to the other: A-001, A-002, ... up to A-040.

    Raises:
        LabelError: they differ by more than their number, or there would be too many.
    """
    if last is None:
        return [first]
    begin, end = (re.fullmatch(r"(.*?)(\d+)", text) for text in (first, last))
    if begin is None or end is None or begin[1] != end[1] or int(begin[2]) > int(end[2]):
        raise LabelError(f"{first} to {last} is no range; give ids that end in a number, such as A-001 A-040")
    if int(end[2]) - int(begin[2]) >= MOST:
        raise LabelError(f"{first} to {last} are more than {MOST} labels; make them in parts")
    width = len(begin[2])
    return [f"{begin[1]}{number:0{width}}" for number in range(int(begin[2]), int(end[2]) + 1)]


def tag_link(site: str, tag_id: str) -> str:
    """Return the address that opens a tag's page. ``site``: where people reach the server.

    Raises:
        LabelError: it is no address of a site.
    """
    parts = urlsplit(site if "://" in site else f"https://{site}")
    if parts.scheme not in ("http", "https") or not parts.hostname or parts.path.strip("/"):
        raise LabelError(f"{site} is no address of a server; give one such as https://192.168.1.5:8000")
    return f"{parts.scheme}://{parts.netloc}/t/{quote(tag_id, safe='')}"


def sheets(tag_ids: Sequence[str], site: str, sheet: Sheet) -> Iterator[Figure]:
    """Yield one figure a sheet, in the size of its paper.

    Raises:
        LabelError: the site is no address, or a link is too long for a QR code.
    """
    from matplotlib.figure import Figure

    width, height = sheet.size_mm
    columns, rows = _GRIDS[sheet.labels]
    size = width / columns, height / rows
    for begin in range(0, len(tag_ids), sheet.labels):
        figure = Figure(figsize=(width * _MM, height * _MM))
        for k, tag_id in enumerate(tag_ids[begin : begin + sheet.labels]):
            place = k % columns / columns, 1.0 - (k // columns + 1) / rows
            axes = figure.add_axes((*place, 1.0 / columns, 1.0 / rows))
            axes.set(xlim=(0.0, size[0]), ylim=(0.0, size[1]))
            axes.axis("off")
            _label(axes, size, tag_id, tag_link(site, tag_id))
        yield figure


def write_pdf(path: Path, tag_ids: Sequence[str], site: str, sheet: Sheet) -> int:
    """Write the sheets and return how many they are.

    Raises:
        LabelError: as ``sheets``.
        OSError: the file cannot be written.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_pdf import PdfPages

    tag_link(site, "")  # before a file is begun
    with rc_context({"pdf.fonttype": 42}), PdfPages(path, metadata={"Title": "Waymark labels"}) as pdf:
        for figure in sheets(tag_ids, site, sheet):
            pdf.savefig(figure)
        return int(pdf.get_pagecount())


def _label(axes: Axes, size: tuple[float, float], tag_id: str, link: str) -> None:
    """Draw one label, in millimetres from its lower left corner; larger ones are the same, drawn larger."""
    width, height = size
    scale = min(height / _BASE_MM, width / 105.0)
    axes.plot([0, width, width, 0, 0], [0, 0, height, height, 0], color="0.7", lw=0.4, ls=":")
    left, top = 5.0 * scale, height - 5.0 * scale
    side = 38.0 * scale
    _qr(axes, link, left, top - side, side)
    number = short_id(tag_id) or tag_id
    right = left + side + 4.0 * scale

    def write(x: float, y: float, text: str, points: float, **how: Any) -> None:
        axes.text(x, y, text, fontsize=points * scale, va="top", family="DejaVu Sans", **how)

    room_mm = width - right - 20.0 * scale
    write(right, top, number, min(26.0, 1.55 * 2.83 * room_mm / scale / max(1, len(number))), weight="bold")
    _north(axes, width - 11.0 * scale, top, scale)
    site = link.removeprefix("https://").rpartition("/")[0]
    for k, text in enumerate(_DO):
        write(right, top - (16.5 + 11.5 * k) * scale, text.format(site=site), 5.6, linespacing=1.3)
    for k, text in enumerate(_LINES):
        y = top - side - (5.0 + 6.3 * k) * scale
        write(left, y + 2.6 * scale, text, 6.0, color="0.25")
        axes.plot([left + 30.0 * scale, width - left], [y, y], color="0.4", lw=0.5)


def _north(axes: Axes, x: float, top: float, scale: float) -> None:
    """Draw the arrow that is laid to the north."""
    axes.fill(
        [x, x + 4.0 * scale, x, x - 4.0 * scale],
        [top, top - 11.0 * scale, top - 8.5 * scale, top - 11.0 * scale],
        color="black",
        lw=0,
    )
    axes.text(x, top - 12.0 * scale, "N", fontsize=9.0 * scale, weight="bold", ha="center", va="top")


def _qr(axes: Axes, link: str, x: float, y: float, side: float) -> None:
    """Draw a QR code that a quarter of dirt leaves readable (level Q), its quiet zone within the square."""
    import numpy as np
    import segno

    try:
        code = segno.make_qr(link, error="q")
    except segno.DataOverflowError as error:
        raise LabelError(f"the link {link} is too long for a QR code; shorten the host or the ids") from error
    dark = np.array([list(row) for row in code.matrix_iter(border=4)], bool)
    axes.imshow(
        ~dark,
        cmap="gray",
        vmin=0,
        vmax=1,
        extent=(x, x + side, y, y + side),
        interpolation="nearest",
        aspect="auto",
    )
