"""Where a mission's world frame lies on the Earth, and finding that from points known in both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, sin

import numpy as np

from server.geo.earth import ecef_m, enu_from_ecef, geodetic

_NEAREST_M = 2.0  # control points nearer to each other say little about the heading
_LARGEST_M = 50_000.0
_SCALE = 0.1  # by how much lengths on map and Earth may differ


class GeometryError(ValueError):
    """Control points that do not tell where the map lies; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class ControlPoint:
    """A place known on the map (world frame, metres) and on the Earth (degrees)."""

    x_m: float
    y_m: float
    lat_deg: float
    lon_deg: float


@dataclass(frozen=True, slots=True)
class Georeference:
    """The world frame on the Earth: where its origin is, and how its x axis is turned from east to north.

    (east, north) = R(yaw) (x, y) in the level plane at the origin. ``sd_m``: the control points' root mean
    square residual, 0 where none were given.
    """

    lat_deg: float
    lon_deg: float
    yaw_rad: float
    height_m: float = 0.0
    sd_m: float = 0.0

    def to_earth(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Return latitude and longitude of a place of the world frame."""
        c, s = cos(self.yaw_rad), sin(self.yaw_rad)
        enu = np.array([c * x_m - s * y_m, s * x_m + c * y_m, 0.0])
        here = ecef_m(self.lat_deg, self.lon_deg, self.height_m)
        lat, lon, _ = geodetic(here + enu_from_ecef(self.lat_deg, self.lon_deg).T @ enu)
        return lat, lon

    def to_map(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        """Return the place of the world frame, in metres, at a latitude and longitude."""
        here = ecef_m(self.lat_deg, self.lon_deg, self.height_m)
        there = ecef_m(lat_deg, lon_deg, self.height_m)
        east, north, _ = enu_from_ecef(self.lat_deg, self.lon_deg) @ (there - here)
        c, s = cos(self.yaw_rad), sin(self.yaw_rad)
        return float(c * east + s * north), float(-s * east + c * north)


def solve(points: Sequence[ControlPoint], height_m: float = 0.0) -> Georeference:
    """Return the georeference that fits control points best (Kabsch 1976, in the plane).

    Raises:
        GeometryError: fewer than two, too near to each other, or lengths that do not fit.
    """
    if len(points) < 2:
        raise GeometryError("one point does not say how the map is turned; give two or more")
    level = Georeference(points[0].lat_deg, points[0].lon_deg, 0.0, height_m)
    on_map = np.array([(p.x_m, p.y_m) for p in points])
    on_earth = np.array([level.to_map(p.lat_deg, p.lon_deg) for p in points])
    a, b = on_map - on_map.mean(axis=0), on_earth - on_earth.mean(axis=0)
    map_m, earth_m = (2.0 * float(np.sqrt((side**2).sum() / len(points))) for side in (a, b))
    _check(map_m, earth_m, len(points))
    yaw = atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    c, s = cos(yaw), sin(yaw)
    turned = a @ np.array([[c, s], [-s, c]])
    sd_m = float(np.sqrt(((turned - b) ** 2).sum() / len(points)))
    if sd_m > _SCALE * map_m + 0.5:
        raise GeometryError(
            f"the points do not fit: on average they are {sd_m:.1f} m off; check that none was mixed up"
        )
    east, north = on_earth.mean(axis=0) - np.array([[c, -s], [s, c]]) @ on_map.mean(axis=0)
    lat, lon = level.to_earth(float(east), float(north))
    # the level plane at the origin is turned from that at the first point, as meridians meet at the poles
    there = Georeference(lat, lon, 0.0, height_m).to_map(*level.to_earth(float(east + c), float(north + s)))
    return Georeference(lat, lon, atan2(there[1], there[0]), height_m, sd_m)


def _check(map_m: float, earth_m: float, count: int) -> None:
    if min(map_m, earth_m) < _NEAREST_M:
        raise GeometryError(
            f"the points are only {min(map_m, earth_m):.1f} m apart; choose some that lie far from each other"
        )
    if max(map_m, earth_m) > _LARGEST_M:
        raise GeometryError(
            f"the points are {max(map_m, earth_m) / 1000.0:.0f} km apart; check their numbers"
        )
    if count == 2 and not 1.0 - _SCALE <= map_m / earth_m <= 1.0 / (1.0 - _SCALE):
        raise GeometryError(
            f"the points are {map_m:.1f} m apart on the map and {earth_m:.1f} m on the Earth;"
            " check that none was mixed up"
        )


def distance_m(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return how far two places (lat, lon) near each other are from each other."""
    return hypot(*Georeference(*a, 0.0).to_map(*b))
