"""The team's grid as a small picture: a palette PNG of three classes, the top row the one farthest north."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from robots.team import TeamGrid

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
_OCCUPIED_FROM = 65  # per cent, as ROS's map_server
_FREE_BELOW = 35
_PALETTE = (0, 0, 0, 222, 230, 236, 24, 34, 44, 69, 214, 160)


@dataclass(frozen=True, slots=True)
class MapImage:
    """A version of the map, as it is served."""

    version: int
    width: int
    height: int
    resolution_m: float
    origin_m: tuple[float, float]
    png: bytes
    etag: str
    explored_m2: float  # of free ground


def draw(grid: TeamGrid) -> MapImage:
    """Return the picture of a grid; pixel values 0 unknown (transparent), 1 free, 2 occupied."""
    return draw_classes(classes_of(grid), grid.version, grid.origin_m, grid.resolution_m)


def classes_of(grid: TeamGrid) -> NDArray[np.uint8]:
    """Return the cells (h, w) as 0 unknown, 1 free, 2 occupied; row 0 at the lowest y."""
    cells = np.asarray(grid.cells)
    classes = np.full(cells.shape, UNKNOWN, np.uint8)
    classes[(cells >= 0) & (cells < _FREE_BELOW)] = FREE
    classes[cells >= _OCCUPIED_FROM] = OCCUPIED
    return classes


def draw_classes(
    classes: NDArray[np.uint8], version: int, origin_m: tuple[float, float], resolution_m: float
) -> MapImage:
    """Return the picture of up to four classes (h, w), row 0 at the lowest y; class 0 is transparent."""
    image = Image.fromarray(np.ascontiguousarray(classes[::-1]), mode=None).convert("P")
    image.putpalette(_PALETTE)
    file = io.BytesIO()
    image.save(file, "PNG", transparency=UNKNOWN, bits=2, compress_level=6)
    png = file.getvalue()
    height, width = classes.shape
    return MapImage(
        version=int(version),
        width=width,
        height=height,
        resolution_m=float(resolution_m),
        origin_m=(float(origin_m[0]), float(origin_m[1])),
        png=png,
        explored_m2=float((classes == FREE).sum()) * float(resolution_m) ** 2,
        etag=f'"{hashlib.sha256(png).hexdigest()[:20]}"',
    )
