"""Victims of several robots as one list: those of one kind that cannot be told apart are one victim."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from robots.se2 import Array, Pose2
from robots.team.types import TeamVictim
from robots.types import VictimEstimate
from robots.victims import BODY_M, FARTHEST_M, SAME_CHI2, apart

Between = Callable[[TeamVictim, TeamVictim], Array]
"""Covariance (2, 2) of where two robots stand to each other, near two victims they saw."""


def merge_victims(seen: Iterable[TeamVictim], between: Between | None = None) -> tuple[TeamVictim, ...]:
    """Return the victims with those merged that agree; the same whatever the order they come in.

    Those that agree best are merged first: of one kind, nearer than chance allows for what both covariances
    and ``between`` say, and never farther apart than ``FARTHEST_M``.
    """
    merged = sorted(seen, key=_order)
    while True:
        pairs = [
            (chi2, i, j)
            for j in range(len(merged))
            for i in range(j)
            if (chi2 := _disagreement(merged[i], merged[j], between)) < SAME_CHI2
        ]
        if not pairs:
            return tuple(merged)
        _, i, j = min(pairs)
        merged[i] = _merge(merged[i], merged.pop(j))


def in_world(robot_id: str, victim: VictimEstimate, world_from_anchor: Pose2) -> TeamVictim:
    """Return one robot's victim in the world, given where the victim's anchor lies there."""
    x, y = world_from_anchor.transform_point(float(victim.position_m[0]), float(victim.position_m[1]))
    c, s = np.cos(world_from_anchor.theta), np.sin(world_from_anchor.theta)
    rotation = np.array([[c, -s], [s, c]])
    covariance = rotation @ victim.covariance @ rotation.T
    return TeamVictim(
        victim_id=victim.victim_id,
        x_m=x,
        y_m=y,
        covariance=covariance,
        confidence=victim.confidence,
        sightings=victim.sightings,
        robots=(robot_id,),
        first_seen_s=victim.first_seen_s,
        last_seen_s=victim.last_seen_s,
        kind=victim.kind,
    )


def _order(victim: TeamVictim) -> tuple[float, str, float, float]:
    return victim.first_seen_s, victim.victim_id, victim.x_m, victim.y_m


def _disagreement(a: TeamVictim, b: TeamVictim, between: Between | None) -> float:
    """Return chi-square of two victims being one; infinite where they cannot be."""
    gap = np.array([b.x_m - a.x_m, b.y_m - a.y_m])
    if a.kind != b.kind or not np.hypot(*gap) < FARTHEST_M:
        return float("inf")
    spread = a.covariance + b.covariance
    if between is not None and a.robots != b.robots:
        spread = spread + between(a, b)
    return 0.0 if np.hypot(*gap) < BODY_M else apart(gap, spread)


def _merge(first: TeamVictim, second: TeamVictim) -> TeamVictim:
    gain = first.covariance @ np.linalg.inv(first.covariance + second.covariance)
    place = np.array([first.x_m, first.y_m]) + gain @ np.array(
        [second.x_m - first.x_m, second.y_m - first.y_m]
    )
    return replace(
        first,
        x_m=float(place[0]),
        y_m=float(place[1]),
        covariance=(np.eye(2) - gain) @ first.covariance,
        confidence=1.0 - (1.0 - first.confidence) * (1.0 - second.confidence),
        sightings=first.sightings + second.sightings,
        robots=tuple(sorted({*first.robots, *second.robots})),
        last_seen_s=max(first.last_seen_s, second.last_seen_s),
    )
