"""From heat readings to victims.

Readings of one place are one victim; a lone reading is a false alarm until confirmed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin

import numpy as np

from robots.config import VictimConfig
from robots.se2 import Array, Pose2
from robots.types import HeatReading, Suspect, VictimEstimate

SAME_CHI2 = 11.8  # two places of one victim disagree by more 3 times in a thousand (2 degrees of freedom)
BODY_M = 0.4  # two nearer than this are one, however sure
FARTHEST_M = 3.0  # and two farther apart than this are not, however vague


def apart(gap_m: Array, covariance: Array) -> float:
    """Return the chi-square of a gap (2,) between two places, given its covariance (2, 2)."""
    return float(gap_m @ np.linalg.solve(covariance, gap_m))


@dataclass(frozen=True, slots=True)
class KnownVictim:
    """A victim as its robot has it: ``place_m`` (x, y) in the map frame, ``confidence`` 0..1."""

    victim_id: str
    place_m: tuple[float, float]
    confidence: float
    last_seen_s: float


class VictimTracker:
    """Victims of one robot, each anchored to the pose vertex it was first seen from."""

    def __init__(self, robot_id: str, config: VictimConfig) -> None:
        self._robot_id = robot_id
        self._config = config
        self._candidates: list[VictimEstimate] = []

    def see(
        self, reading: HeatReading, stamp_s: float, map_from_base: Pose2, anchor: int, anchors: list[Pose2]
    ) -> VictimEstimate | None:
        """Take in a reading; return the victim it belongs to once that has been seen often enough."""
        x, y = reading.range_m * cos(reading.bearing_rad), reading.range_m * sin(reading.bearing_rad)
        place = np.array(map_from_base.transform_point(x, y))
        covariance = self._covariance(reading, map_from_base.theta + reading.bearing_rad)
        at = self._nearest(place, covariance, anchors)
        if at is None:
            estimate = self._new(place, covariance, reading, stamp_s, anchor, anchors[anchor])
            self._candidates.append(estimate)
        else:
            estimate = self._updated(self._candidates[at], place, covariance, reading, stamp_s, anchors)
            self._candidates[at] = estimate
        return estimate if estimate.sightings >= self._config.min_sightings else None

    def victims(self) -> tuple[VictimEstimate, ...]:
        """Return all victims seen often enough."""
        return tuple(v for v in self._candidates if v.sightings >= self._config.min_sightings)

    def known(self, anchors: list[Pose2]) -> tuple[KnownVictim, ...]:
        """Return all victims seen often enough, in the map frame."""
        return tuple(
            KnownVictim(v.victim_id, _place(v, anchors[v.anchor]), v.confidence, v.last_seen_s)
            for v in self.victims()
        )

    def suspects(self, anchors: list[Pose2]) -> tuple[Suspect, ...]:
        """Return what was not seen often enough yet to be a victim, in the map frame."""
        return tuple(
            Suspect(v.victim_id, _place(v, anchors[v.anchor]), v.sightings, v.last_seen_s)
            for v in self._candidates
            if v.sightings < self._config.min_sightings
        )

    def _covariance(self, reading: HeatReading, direction_rad: float) -> Array:
        along = self._config.range_sd_m**2
        across = (self._config.bearing_sd_rad * max(reading.range_m, 0.3)) ** 2
        c, s = cos(direction_rad), sin(direction_rad)
        rotation = np.array([[c, -s], [s, c]])
        covariance: Array = rotation @ np.diag([along, across]) @ rotation.T
        return covariance

    def _nearest(self, place: Array, covariance: Array, anchors: list[Pose2]) -> int | None:
        """Return the nearest candidate that a reading of this covariance may be of."""
        best, best_distance = None, self._config.same_within_m
        for k, candidate in enumerate(self._candidates):
            anchor = anchors[candidate.anchor]
            gap = anchor.transform(candidate.position_m[None])[0] - place
            distance = float(np.hypot(*gap))
            if distance >= best_distance:
                continue
            spread = covariance + _rotated(candidate.covariance, anchor.theta)
            if distance < BODY_M or apart(gap, spread) < SAME_CHI2:
                best, best_distance = k, distance
        return best

    def _new(
        self, place: Array, covariance: Array, reading: HeatReading, stamp_s: float, anchor: int, pose: Pose2
    ) -> VictimEstimate:
        anchor_from_map = pose.inverse()
        return VictimEstimate(
            victim_id=f"{self._robot_id}-V{len(self._candidates) + 1}",
            anchor=anchor,
            position_m=anchor_from_map.transform(place[None])[0],
            covariance=_rotated(covariance, anchor_from_map.theta),
            confidence=0.5 * reading.confidence,
            sightings=1,
            first_seen_s=stamp_s,
            last_seen_s=stamp_s,
        )

    def _updated(
        self,
        old: VictimEstimate,
        place: Array,
        covariance: Array,
        reading: HeatReading,
        stamp_s: float,
        anchors: list[Pose2],
    ) -> VictimEstimate:
        anchor_from_map = anchors[old.anchor].inverse()
        seen = anchor_from_map.transform(place[None])[0]
        noise = _rotated(covariance, anchor_from_map.theta)
        gain = old.covariance @ np.linalg.inv(old.covariance + noise)
        fused = (np.eye(2) - gain) @ old.covariance
        # readings a moment apart share the sensor's bias: the place never becomes surer than 10 cm
        fused += np.eye(2) * max(0.0, 0.01 - float(np.linalg.eigvalsh(fused)[0]))
        return replace(
            old,
            position_m=old.position_m + gain @ (seen - old.position_m),
            covariance=fused,
            confidence=1.0 - (1.0 - old.confidence) * (1.0 - 0.3 * reading.confidence),
            sightings=old.sightings + 1,
            last_seen_s=stamp_s,
        )


def _place(victim: VictimEstimate, anchor: Pose2) -> tuple[float, float]:
    return anchor.transform_point(float(victim.position_m[0]), float(victim.position_m[1]))


def _rotated(covariance: Array, angle_rad: float) -> Array:
    c, s = cos(angle_rad), sin(angle_rad)
    rotation = np.array([[c, -s], [s, c]])
    rotated: Array = rotation @ covariance @ rotation.T
    return rotated
