"""WGS 84: latitude and longitude in degrees, places in space, and the level plane at a point of the Earth."""

from __future__ import annotations

from math import atan2, cos, degrees, hypot, radians, sin, sqrt

import numpy as np

from robots.se2 import Array

A_M = 6378137.0
F = 1.0 / 298.257223563
_E2 = F * (2.0 - F)


def ecef_m(lat_deg: float, lon_deg: float, height_m: float = 0.0) -> Array:
    """Return a point in the frame of the Earth, shape (3,), metres."""
    lat, lon = radians(lat_deg), radians(lon_deg)
    radius = A_M / sqrt(1.0 - _E2 * sin(lat) ** 2)
    out = (radius + height_m) * cos(lat)
    return np.array([out * cos(lon), out * sin(lon), (radius * (1.0 - _E2) + height_m) * sin(lat)])


def geodetic(point_m: Array) -> tuple[float, float, float]:
    """Return latitude and longitude in degrees and height in metres of a point (3,) near the surface.

    Bowring's (1976) formula iterated on the reduced latitude: exact to the last digits within 10 km of it.
    """
    x, y, z = (float(value) for value in point_m)
    flat = hypot(x, y)
    b = A_M * (1.0 - F)
    reduced = atan2(z, flat * (1.0 - F))
    lat = 0.0
    for _ in range(5):
        up = z + _E2 / (1.0 - _E2) * b * sin(reduced) ** 3
        out = flat - _E2 * A_M * cos(reduced) ** 3
        lat = atan2(up, out)
        reduced = atan2((1.0 - F) * sin(lat), cos(lat))
    radius = A_M / sqrt(1.0 - _E2 * sin(lat) ** 2)
    height = flat * cos(lat) + z * sin(lat) - A_M * A_M / radius
    return degrees(lat), degrees(atan2(y, x)), height


def enu_from_ecef(lat_deg: float, lon_deg: float) -> Array:
    """Return the rotation (3, 3) from the frame of the Earth to east, north and up at a place."""
    lat, lon = radians(lat_deg), radians(lon_deg)
    return np.array(
        [
            [-sin(lon), cos(lon), 0.0],
            [-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)],
            [cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)],
        ]
    )
