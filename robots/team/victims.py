"""Victims of several robots as one list: sightings of one place are one victim."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from robots.se2 import Pose2
from robots.team.types import TeamVictim
from robots.types import VictimEstimate

_SAME_VICTIM_M = 1.5


def merge_victims(seen: Iterable[TeamVictim]) -> tuple[TeamVictim, ...]:
    """Return the victims with those of one place merged; the same whatever the order they come in."""
    merged: list[TeamVictim] = []
    for victim in sorted(seen, key=lambda v: (v.first_seen_s, v.victim_id)):
        near = [
            k
            for k, m in enumerate(merged)
            if np.hypot(m.x_m - victim.x_m, m.y_m - victim.y_m) < _SAME_VICTIM_M
        ]
        if near:
            merged[near[0]] = _merge(merged[near[0]], victim)
        else:
            merged.append(victim)
    return tuple(merged)


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
    )


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
