"""Reading ROS map_server maps: a YAML file beside an image.

Unknown cells count as solid: nobody drives there.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, isfinite, sin
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from robots.sim.world import MAX_CELLS, Mask, World, WorldError, world_of

_MODES = ("trinary", "scale", "raw")


@dataclass(frozen=True, slots=True)
class _MapFile:
    """The fields of a map_server YAML file.

    ``origin`` is x, y in metres and yaw in radians of the lower left corner.
    """

    image: Path
    resolution_m: float
    origin: tuple[float, float, float]
    negate: bool
    free_threshold: float
    mode: str


def load_map(path: Path) -> World:
    """Return the world of a map_server map.

    Raises:
        WorldError: a file is missing or damaged, a field is bad, or nothing in the map is free.
    """
    fields = _read_fields(path)
    solid = ~_free_cells(fields)[::-1]  # image row 0 is the top
    if solid.all():
        raise WorldError(f"{path}: the map has no free space; check negate, free_thresh and the image")
    x, y, yaw = fields.origin
    if yaw == 0.0:
        return world_of(solid, fields.resolution_m, (x, y))
    turned, corner = _turned(solid, fields.resolution_m, yaw)
    return world_of(turned, fields.resolution_m, (x + corner[0], y + corner[1]))


def _read_fields(path: Path) -> _MapFile:
    try:
        raw = yaml.safe_load(path.read_text())
    except OSError as error:
        raise WorldError(f"{path}: cannot read the map ({error.strerror}); check the path") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise WorldError(f"{path}: this is not a YAML file; give the map's .yaml, not its image") from error
    if not isinstance(raw, dict):
        raise WorldError(f"{path}: expected the fields of a map_server map (image, resolution, origin)")
    for name in ("image", "resolution", "origin"):
        if name not in raw:
            raise WorldError(f"{path}: the field {name} is missing; add it")
    image = raw["image"]
    if not isinstance(image, str) or not image:
        raise WorldError(f"{path}: image has to be the name of the image file")
    resolution = _number(path, "resolution", raw["resolution"])
    if not 0.005 <= resolution <= 1.0:
        raise WorldError(f"{path}: resolution {resolution:g} has to lie between 0.005 and 1 m per pixel")
    origin = raw["origin"]
    if not isinstance(origin, list) or len(origin) not in (2, 3):
        raise WorldError(f"{path}: origin has to be a list [x, y, yaw]")
    x, y, yaw = (_number(path, "origin", value) for value in [*origin, 0.0][:3])
    negate = raw.get("negate", 0)
    if negate not in (0, 1):
        raise WorldError(f"{path}: negate has to be 0 or 1")
    free = _number(path, "free_thresh", raw.get("free_thresh", 0.196))
    occupied = _number(path, "occupied_thresh", raw.get("occupied_thresh", 0.65))
    if not 0.0 <= free < occupied <= 1.0:
        raise WorldError(f"{path}: free_thresh has to be smaller than occupied_thresh, both in 0..1")
    mode = raw.get("mode", "trinary")
    if mode not in _MODES:
        raise WorldError(f"{path}: mode {mode!r} is unknown; use one of {', '.join(_MODES)}")
    return _MapFile(path.parent / image, resolution, (x, y, yaw), bool(negate), free, mode)


def _number(path: Path, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise WorldError(f"{path}: {name} has to be a finite number, not {value!r}")
    return float(value)


def _free_cells(fields: _MapFile) -> Mask:
    """Return which pixels are free, bool (h, w), row 0 at the top.

    Free is darkness below free_thresh; what lies between the thresholds is unknown (trinary) or partly
    occupied (scale), and in raw mode a value above 100 is unknown: none of them is free.
    """
    try:
        with Image.open(fields.image) as image:
            if image.width * image.height > MAX_CELLS:
                raise WorldError(
                    f"{fields.image}: {image.width} x {image.height} pixels are too many;"
                    f" at most {MAX_CELLS} are read: reduce the image"
                )
            grey, alpha = image.convert("LA").split()
            values: NDArray[np.uint8] = np.asarray(grey)
            opaque = np.asarray(alpha) == 255  # transparent means unknown
    except OSError as error:
        if isinstance(error, UnidentifiedImageError):
            raise WorldError(
                f"{fields.image}: this is not an image that can be read; use PNG or PGM"
            ) from error
        reason = error.strerror or "the file is damaged"
        raise WorldError(
            f"{fields.image}: cannot read the map's image ({reason}); check image in the YAML"
        ) from error
    except (Image.DecompressionBombError, SyntaxError, ValueError) as error:
        if isinstance(error, WorldError):
            raise
        raise WorldError(f"{fields.image}: the image is damaged or far too large; export it again") from error
    if fields.mode == "raw":
        free = values < 100.0 * fields.free_threshold
    else:
        darkness = (values if fields.negate else 255.0 - values) / 255.0
        free = darkness < fields.free_threshold
    result: Mask = free & opaque
    return result


def _turned(solid: Mask, resolution_m: float, yaw_rad: float) -> tuple[Mask, tuple[float, float]]:
    """Return the grid turned about its lower left corner, and the new grid's corner seen from it, metres."""
    height, width = solid.shape
    c, s = cos(yaw_rad), sin(yaw_rad)
    corners = np.array([(0, 0), (width, 0), (0, height), (width, height)]) @ np.array([[c, s], [-s, c]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    columns, rows = (ceil(value) for value in high - low)
    x, y = np.meshgrid(low[0] + np.arange(columns) + 0.5, low[1] + np.arange(rows) + 0.5)
    column, row = np.floor(c * x + s * y).astype(int), np.floor(-s * x + c * y).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    turned = np.ones((rows, columns), dtype=bool)
    turned[inside] = solid[row[inside], column[inside]]
    return turned, (float(low[0]) * resolution_m, float(low[1]) * resolution_m)
