"""Settings of the strategies, part of an agent's configuration (``robots.config``)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SafeGroundConfig:
    """Strategies over safe and free ground (Amigoni 2013)."""

    safe_m: float = 3.0  # so far round the robot the ground is safe
    sweep: bool = False  # waymark makes ground safe, rather than seeing it from afar
    base_reach_m: float = 30.0  # at which the chance to reach the base by radio is 61 %


@dataclass(frozen=True, slots=True)
class KleinerConfig:
    """Frontiers and visited places on tags (Kleiner 2006 eq. 6 and 7)."""

    alpha: float = 1.0  # worth of a metre of way
    beta: float = 0.2  # m, of a visited place a metre away, in the corrected form
    printed_beta: float = 0.01  # s/m, of eq. (7) as printed: its sum is a hundred times greater
    tau_m: float = 4.0  # radius of influence of tags and visited places


@dataclass(frozen=True, slots=True)
class ZiparoConfig:
    """Exploring by a small map and the tags in it (Ziparo 2007 eq. 6 and 7)."""

    alpha: float = 10.0  # how dear ways near obstacles are
    obstacle_sd_m: float = 0.2  # of the Gaussian by which obstacles are widened
    gamma_angle: float = 1.0  # 1/rad2
    gamma_visited: float = 0.1  # m
