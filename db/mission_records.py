"""What the store hands out of how missions go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class EndingRecord:
    """What is left of a mission that was closed: its board, and its map as an encoded ``TeamGrid``."""

    ended_unix_s: float
    board: dict[str, dict[str, Any]]
    grid: bytes | None


@dataclass(frozen=True, slots=True)
class ProgressRecord:
    """How far a mission was at a moment; ``clock_s`` is its robots' own."""

    unix_s: float
    clock_s: float
    explored_m2: float
    tags: int
    victims: int


@dataclass(frozen=True, slots=True)
class GeoreferenceRecord:
    """Where the world frame lies on the Earth (WGS 84), and the control points that said so, if any did.

    Each of ``points``: x_m, y_m, lat_deg, lon_deg.
    """

    lat_deg: float
    lon_deg: float
    yaw_rad: float
    height_m: float
    sd_m: float
    points: tuple[tuple[float, float, float, float], ...]
    by: str
    changed_unix_s: float

    @classmethod
    def of(cls, value: dict[str, Any]) -> GeoreferenceRecord:
        """Return it of its plain values, as they are stored and go over the wire."""
        points = tuple((float(x), float(y), float(lat), float(lon)) for x, y, lat, lon in value["points"])
        return cls(**{**value, "points": points})


@dataclass(frozen=True, slots=True)
class BaseMapRecord:
    """A map that was there before the mission, as an encoded ``TeamGrid``; ``source``: where it is from."""

    source: str
    grid: bytes
    by: str
    changed_unix_s: float
