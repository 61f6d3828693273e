"""Universal Transverse Mercator on WGS 84: Krüger's series, exact to less than a micrometre.

Karney, Transverse Mercator with an accuracy of a few nanometers, J. Geodesy 85 (2011), equations 7 to 11, 35
and 36, to the fourth order in n.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asinh, atan, atan2, atanh, cos, cosh, degrees, hypot, radians, sin, sinh, sqrt, tan

from server.geo.earth import A_M, F

SOUTHERNMOST_DEG, NORTHERNMOST_DEG = -80.0, 84.0
_K0 = 0.9996
_FALSE_EASTING_M, _FALSE_NORTHING_M = 500_000.0, 10_000_000.0
_N = F / (2.0 - F)
_E = sqrt(F * (2.0 - F))
_A = A_M / (1.0 + _N) * (1.0 + _N**2 / 4.0 + _N**4 / 64.0)  # eq. 14
_ALPHA = (
    _N / 2.0 - 2.0 / 3.0 * _N**2 + 5.0 / 16.0 * _N**3 + 41.0 / 180.0 * _N**4,
    13.0 / 48.0 * _N**2 - 3.0 / 5.0 * _N**3 + 557.0 / 1440.0 * _N**4,
    61.0 / 240.0 * _N**3 - 103.0 / 140.0 * _N**4,
    49561.0 / 161280.0 * _N**4,
)  # eq. 35
_BETA = (
    _N / 2.0 - 2.0 / 3.0 * _N**2 + 37.0 / 96.0 * _N**3 - 1.0 / 360.0 * _N**4,
    1.0 / 48.0 * _N**2 + 1.0 / 15.0 * _N**3 - 437.0 / 1440.0 * _N**4,
    17.0 / 480.0 * _N**3 - 37.0 / 840.0 * _N**4,
    4397.0 / 161280.0 * _N**4,
)  # eq. 36


@dataclass(frozen=True, slots=True)
class Utm:
    """A place in a zone, 1 to 60, of the northern or the southern half; metres."""

    zone: int
    north: bool
    easting_m: float
    northing_m: float

    def __str__(self) -> str:
        half = "N" if self.north else "S"
        return f"{self.zone}{half} {self.easting_m:.0f} {self.northing_m:.0f}"


def zone_of(lat_deg: float, lon_deg: float) -> int:
    """Return the zone of a place; Norway's and Svalbard's are of other widths."""
    lon = (lon_deg + 180.0) % 360.0 - 180.0
    if 56.0 <= lat_deg < 64.0 and 3.0 <= lon < 12.0:
        return 32
    if lat_deg >= 72.0 and 0.0 <= lon < 42.0:
        return 31 if lon < 9.0 else 33 if lon < 21.0 else 35 if lon < 33.0 else 37
    return int((lon + 180.0) // 6.0) + 1


def central_meridian_deg(zone: int) -> float:
    """Return the longitude in the middle of a zone."""
    return 6.0 * zone - 183.0


def to_utm(lat_deg: float, lon_deg: float, zone: int | None = None) -> Utm:
    """Return a place in UTM, in its own zone or the one given.

    Raises:
        ValueError: it is nearer to a pole than UTM reaches.
    """
    if not SOUTHERNMOST_DEG <= lat_deg <= NORTHERNMOST_DEG:
        raise ValueError(f"latitude {lat_deg:.4f} lies beyond UTM, which reaches from 80 south to 84 north")
    zone = zone_of(lat_deg, lon_deg) if zone is None else zone
    lon = radians((lon_deg - central_meridian_deg(zone) + 180.0) % 360.0 - 180.0)
    tau = tan(radians(lat_deg))
    sigma = sinh(_E * atanh(_E * tau / hypot(1.0, tau)))  # eq. 9
    conformal = tau * hypot(1.0, sigma) - sigma * hypot(1.0, tau)  # eq. 7
    xi0, eta0 = atan2(conformal, cos(lon)), asinh(sin(lon) / hypot(conformal, cos(lon)))  # eq. 10
    xi, eta = xi0, eta0
    for j, alpha in enumerate(_ALPHA, 1):  # eq. 11
        xi += alpha * sin(2 * j * xi0) * cosh(2 * j * eta0)
        eta += alpha * cos(2 * j * xi0) * sinh(2 * j * eta0)
    north = lat_deg >= 0.0
    northing = _K0 * _A * xi + (0.0 if north else _FALSE_NORTHING_M)
    return Utm(zone, north, _FALSE_EASTING_M + _K0 * _A * eta, northing)


def from_utm(place: Utm) -> tuple[float, float]:
    """Return latitude and longitude of a place in degrees."""
    shift = 0.0 if place.north else _FALSE_NORTHING_M
    xi0, eta0 = (place.northing_m - shift) / (_K0 * _A), (place.easting_m - _FALSE_EASTING_M) / (_K0 * _A)
    xi, eta = xi0, eta0
    for j, beta in enumerate(_BETA, 1):
        xi -= beta * sin(2 * j * xi0) * cosh(2 * j * eta0)
        eta -= beta * cos(2 * j * xi0) * sinh(2 * j * eta0)
    conformal = sin(xi) / hypot(sinh(eta), cos(xi))
    tau = conformal
    for _ in range(4):  # eq. 19 to 21, Newton's steps
        sigma = sinh(_E * atanh(_E * tau / hypot(1.0, tau)))
        found = tau * hypot(1.0, sigma) - sigma * hypot(1.0, tau)
        slope = (1.0 + (1.0 - _E**2) * tau**2) / ((1.0 - _E**2) * hypot(1.0, tau))
        tau += (conformal - found) / hypot(1.0, found) * slope
    lon = central_meridian_deg(place.zone) + degrees(atan2(sinh(eta), cos(xi)))
    return degrees(atan(tau)), (lon + 180.0) % 360.0 - 180.0
