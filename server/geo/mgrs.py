"""The Military Grid Reference System, as rescue teams read places out: zone, band, square, metres in it."""

from __future__ import annotations

import re

from server.geo.utm import Utm, central_meridian_deg, from_utm, to_utm

_BANDS = "CDEFGHJKLMNPQRSTUVWX"  # 8 degrees each from 80 south, the last 12
_COLUMNS = ("STUVWXYZ", "ABCDEFGH", "JKLMNPQR")  # by zone modulo 3
_ROWS = "ABCDEFGHJKLMNPQRSTUV"
_SQUARE_M = 100_000
_ROUND_M = 2_000_000.0  # the letters of the rows come again
_FORM = re.compile(r"(\d{1,2})([C-HJ-NP-X])([A-HJ-NP-Z])([A-HJ-NP-V])(\d*)")


def to_mgrs(lat_deg: float, lon_deg: float) -> str:
    """Return the reference of the square metre a place lies in, as ``32U PU 91607 34903``.

    Raises:
        ValueError: it is nearer to a pole than UTM reaches.
    """
    utm = to_utm(lat_deg, lon_deg)
    band = _BANDS[min(int((lat_deg + 80.0) // 8.0), len(_BANDS) - 1)]
    column, east = divmod(int(utm.easting_m), _SQUARE_M)
    row, north = divmod(int(utm.northing_m), _SQUARE_M)
    square = _COLUMNS[utm.zone % 3][column - 1] + _ROWS[(row + _shift(utm.zone)) % len(_ROWS)]
    return f"{utm.zone}{band} {square} {east:05d} {north:05d}"


def from_mgrs(text: str) -> tuple[float, float]:
    """Return latitude and longitude of the middle of the square that a reference names; spaces do not count.

    Raises:
        ValueError: it is no grid reference.
    """
    wrong = f"{text!r} is no grid reference; write it like 32U PU 91607 34903"
    found = _FORM.fullmatch(re.sub(r"\s+", "", text).upper())
    if found is None:
        raise ValueError(wrong)
    zone, band, column, row, digits = int(found[1]), found[2], found[3], found[4], found[5]
    if not 1 <= zone <= 60 or len(digits) % 2 or len(digits) > 10 or column not in _COLUMNS[zone % 3]:
        raise ValueError(wrong)
    half = len(digits) // 2
    size_m = 10.0 ** (5 - half)
    east = int(digits[:half] or 0) * size_m + size_m / 2.0
    north = int(digits[half:] or 0) * size_m + size_m / 2.0
    easting = (_COLUMNS[zone % 3].index(column) + 1) * _SQUARE_M + east
    row_m = (_ROWS.index(row) - _shift(zone)) % len(_ROWS) * float(_SQUARE_M)
    south_deg = 8.0 * _BANDS.index(band) - 80.0
    is_north = south_deg >= 0.0
    base = to_utm(south_deg, central_meridian_deg(zone), zone).northing_m
    # squares of a band may begin a little south of its own edge, whose northing falls off the meridian
    lowest = base - (_SQUARE_M if is_north else 2.0 * _SQUARE_M)
    northing = row_m + north
    while northing < lowest:
        northing += _ROUND_M
    lat, lon = from_utm(Utm(zone, is_north, easting, northing))
    if not south_deg - 2.0 <= lat <= south_deg + (14.0 if band == "X" else 10.0):
        raise ValueError(f"{wrong}; that square does not lie in band {band}")
    return lat, lon


def _shift(zone: int) -> int:
    """Return by how many rows the letters begin later: in even zones by five."""
    return 5 if zone % 2 == 0 else 0
