"""A plan that was there before the mission: a picture with metres per pixel, as ROS's map_server has it."""

from __future__ import annotations

import io
from dataclasses import dataclass
from math import ceil, cos, isfinite, sin
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image

from robots.team import TeamGrid
from server.map_image import FREE, OCCUPIED, MapImage

MAX_PIXELS = 16_000_000
MAX_YAML = 4000
_FORMATS = ("PNG", "PPM", "JPEG", "WEBP")  # PPM is PGM too
_UNKNOWN = -1


class BaseMapError(ValueError):
    """The file is no plan; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class MapWords:
    """What the YAML beside a picture says. ``origin``: x and y in metres and yaw of its lower left corner.

    Darker than ``occupied_thresh`` is a wall, lighter than ``free_thresh`` floor, between them unknown.
    """

    resolution_m: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    negate: bool = False
    occupied_thresh: float = 0.65
    free_thresh: float = 0.196

    def __post_init__(self) -> None:
        """Refuse what makes no map.

        Raises:
            BaseMapError: a number is out of its range.
        """
        if not 0.001 <= self.resolution_m <= 10.0:
            raise BaseMapError(
                f"resolution {self.resolution_m:g} has to lie between 0.001 and 10 m per pixel"
            )
        if not 0.0 <= self.free_thresh < self.occupied_thresh <= 1.0:
            raise BaseMapError("free_thresh has to be smaller than occupied_thresh, both in 0..1")
        if not all(isfinite(value) and abs(value) < 1e6 for value in self.origin):
            raise BaseMapError("origin has to be [x, y, yaw] in metres and radians")


def words_of(text: str) -> MapWords:
    """Return what a map_server YAML file says; the name of its picture does not count.

    Raises:
        BaseMapError: it is no such file.
    """
    if len(text) > MAX_YAML:
        raise BaseMapError("the YAML is too long for a map's; send the one beside the picture")
    try:
        told = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise BaseMapError("the YAML cannot be read; send the one beside the picture") from error
    if not isinstance(told, dict) or "resolution" not in told:
        raise BaseMapError("the YAML has no resolution; send the one beside the picture")
    origin = told.get("origin", [0.0, 0.0, 0.0])
    if not isinstance(origin, list) or len(origin) not in (2, 3):
        raise BaseMapError("origin has to be a list [x, y, yaw]")
    x, y, yaw = (_number("origin", value) for value in [*origin, 0.0][:3])
    return MapWords(
        _number("resolution", told["resolution"]),
        (x, y, yaw),
        told.get("negate", 0) in (1, True),
        _number("occupied_thresh", told.get("occupied_thresh", 0.65)),
        _number("free_thresh", told.get("free_thresh", 0.196)),
    )


def grid_of(file: bytes, words: MapWords) -> TeamGrid:
    """Return the plan in a picture as a grid of the world frame.

    Raises:
        BaseMapError: no PNG, PGM, JPEG or WebP, damaged, or too large.
    """
    try:
        with Image.open(io.BytesIO(file), formats=_FORMATS) as image:
            if image.width * image.height > MAX_PIXELS:
                text = f"the plan has {image.width} x {image.height} pixels; send one of at most 16 million"
                raise BaseMapError(text)
            grey, alpha = image.convert("LA").split()
    except BaseMapError:
        raise
    except (OSError, SyntaxError, ValueError, OverflowError, Image.DecompressionBombError) as error:
        text = "this file is no plan that can be read: send a PNG, PGM, JPEG or WebP that is whole"
        raise BaseMapError(text) from error
    values = np.asarray(grey, np.float32)
    darkness = (values if words.negate else 255.0 - values) / 255.0
    cells = np.full(values.shape, _UNKNOWN, np.int8)
    cells[darkness < words.free_thresh] = 0
    cells[darkness > words.occupied_thresh] = 100
    cells[np.asarray(alpha) < 128] = _UNKNOWN
    x, y, yaw = words.origin
    turned, corner = _turned(cells[::-1], yaw)  # row 0 of a picture is the top
    origin = (x + corner[0] * words.resolution_m, y + corner[1] * words.resolution_m)
    return TeamGrid(turned, origin, words.resolution_m, 0)


def grid_of_image(image: MapImage) -> TeamGrid:
    """Return the grid that a map's picture shows."""
    with Image.open(io.BytesIO(image.png), formats=("PNG",)) as file:
        classes = np.asarray(file)[::-1]
    cells = np.full(classes.shape, _UNKNOWN, np.int8)
    cells[classes == FREE] = 0
    cells[classes == OCCUPIED] = 100
    return TeamGrid(cells, image.origin_m, image.resolution_m, 0)


def _turned(cells: NDArray[np.int8], yaw_rad: float) -> tuple[NDArray[np.int8], tuple[float, float]]:
    """Return cells turned about their lower left corner, and where the new corner lies from it, in cells."""
    if yaw_rad == 0.0:
        return np.ascontiguousarray(cells), (0.0, 0.0)
    height, width = cells.shape
    c, s = cos(yaw_rad), sin(yaw_rad)
    corners = np.array([(0, 0), (width, 0), (0, height), (width, height)]) @ np.array([[c, s], [-s, c]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    columns, rows = (ceil(value - 1e-9) for value in high - low)
    if columns * rows > 2 * MAX_PIXELS:
        raise BaseMapError("turned by its yaw the plan has too many pixels; send a smaller one")
    x, y = np.meshgrid(low[0] + np.arange(columns) + 0.5, low[1] + np.arange(rows) + 0.5)
    column, row = np.floor(c * x + s * y).astype(int), np.floor(-s * x + c * y).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    turned = np.full((rows, columns), _UNKNOWN, np.int8)
    turned[inside] = cells[row[inside], column[inside]]
    return turned, (float(low[0]), float(low[1]))


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise BaseMapError(f"{name} has to be a finite number")
    return float(value)
