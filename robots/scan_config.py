"""Settings of matching scans and of closing loops by them; parts of ``robots.config.AgentConfig``."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians


@dataclass(frozen=True, slots=True)
class ScanMatchConfig:
    """Matching a scan against a local map of the most recent scans."""

    local_scans: int = 25
    insert_after_m: float = 0.25
    insert_after_rad: float = radians(15.0)
    max_far_fraction: float = 0.82  # Kleiner 2006 theta, as a fraction of the beams
    max_range_m: float = 30.0
    min_points: int = 20
    max_correction_m: float = 0.6
    max_correction_rad: float = radians(25.0)
    point_sd_m: float = 0.03
    min_overlap: float = 0.45
    map_sd_m: float = 0.008  # error of the local map itself, over about a metre of driving
    map_sd_rad: float = radians(0.2)


@dataclass(frozen=True, slots=True)
class LoopConfig:
    """Loops closed by laser at tags that are seen again."""

    laser: bool = True
    reach_m: float = 4.0  # scans of so much driving before and after a sighting make up its surroundings
    key_scan_m: float = 0.2  # one scan is kept each so far,
    key_scan_rad: float = radians(12.0)  # or after such a turn
    earlier_sightings: int = 3  # that a new one is matched with
    window_m: float = 0.7  # how far off the graph may be
    window_rad: float = radians(30.0)
    min_overlap: float = 0.8
    min_margin: float = 0.1
