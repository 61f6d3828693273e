"""Going to what looked warm: nearer and nearer until it is a victim for sure, or nothing is there.

What a tag calls a victim is not gone to: somebody is sure of it, and it is reported already. Seen in passing
often enough it is reported by this robot as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, radians

from robots.exploration.aim import Aim
from robots.exploration.ground import Ground
from robots.exploration.told.claims import ToldVictim
from robots.se2 import Pose2, wrap
from robots.types import Suspect

_REACH_M = 6.0  # farther off it was seen from elsewhere, and is left
_BESIDE_M = 1.2  # a body lies on ground that cannot be driven
_NEAR_M = 0.7  # near enough to look
_LOOK_M, _LOOK_CONE_RAD = 2.5, radians(50.0)  # so near and in the cone it ought to be seen again
_LOOK_S = 2.0  # not seen again for so long, it was nothing
_VISIT_S = 30.0  # at most so long for one
_SAID_S = 10.0  # so long it says what it left to others
_FRESH_S = 5.0  # seen longer ago, it is left: something else was more important then


class Suspects:
    """Which suspect a robot is looking into; those it has looked into are not gone to again."""

    def __init__(self) -> None:
        self._now: Suspect | None = None
        self._looked_s = 0.0
        self._since_s = 0.0
        self._last_s = 0.0
        self._settled: dict[str, None] = {}
        self._left: tuple[float, float] | None = None  # until when it is said, and how far off it was

    @property
    def place_m(self) -> tuple[float, float] | None:
        """Where the suspect is that is looked into (map frame)."""
        return None if self._now is None else self._now.place_m

    def observe(
        self, now_s: float, pose: Pose2, suspects: Sequence[Suspect], told: Sequence[ToldVictim] = ()
    ) -> bool:
        """Take in what is suspected and told of (map frame); say whether that asks for a new plan."""
        passed_s, self._last_s = now_s - self._last_s, now_s
        left = self._leave_known(now_s, pose, suspects, told)
        known = {suspect.victim_id: suspect for suspect in suspects}
        before = self._now
        if before is not None:
            self._now = known.get(before.victim_id)  # gone: it is a victim now
            if self._now is not None:
                self._look(self._now, before, pose, passed_s, now_s)
        if self._now is None:
            fresh = [s for s in suspects if self._is_fresh(s, now_s, pose)]
            self._now = min(fresh, key=lambda s: (pose_gap(pose, s), s.victim_id), default=None)
            self._looked_s, self._since_s = 0.0, now_s
        return left or (None if before is None else before.victim_id) != (
            None if self._now is None else self._now.victim_id
        )

    def known_to_others(self, now_s: float) -> str:
        """Return in words, after a reason, what was just left because others know of it; or nothing."""
        if self._left is None or now_s > self._left[0]:
            return ""
        gap_m = self._left[1]
        return f"; passing the warm spot {gap_m:.0f} m away, a tag says that a robot found a victim there"

    def aim(self, ground: Ground) -> Aim | None:
        """Return the way to the suspect, None where there is none or no way to it."""
        suspect = self._now
        if suspect is None:
            return None
        x, y = suspect.place_m
        cell = ground.nearest(x, y, _BESIDE_M)
        path = None if cell is None else ground.path_to(cell)
        if path is None:
            self.give_up()
            return None
        reason = f"a possible victim {ground.distance_m(x, y):.1f} m away: going nearer to make sure"
        return Aim("suspect", "exploring", reason, suspect.place_m, path)

    def give_up(self) -> None:
        """Leave the suspect for good: it cannot be got at."""
        if self._now is not None:
            self._settled[self._now.victim_id] = None
            self._now = None

    def turn_to(self, pose: Pose2) -> float | None:
        """Return the bearing (rad) of a suspect that is near enough to be looked at from here."""
        if self._now is None or pose_gap(pose, self._now) > _NEAR_M + _BESIDE_M:
            return None
        x, y = self._now.place_m
        return wrap(atan2(y - pose.y, x - pose.x) - pose.theta)

    def _leave_known(
        self, now_s: float, pose: Pose2, suspects: Sequence[Suspect], told: Sequence[ToldVictim]
    ) -> bool:
        """Settle what is known as a victim already; say whether something was."""
        known = [
            s
            for s in suspects
            if s.victim_id not in self._settled
            and any(hypot(s.place_m[0] - v.x, s.place_m[1] - v.y) < v.within_m for v in told)
        ]
        for suspect in known:
            self._settled[suspect.victim_id] = None
            self._left = now_s + _SAID_S, pose_gap(pose, suspect)
            if self._now is not None and self._now.victim_id == suspect.victim_id:
                self._now = None
        return bool(known)

    def _look(self, suspect: Suspect, before: Suspect, pose: Pose2, passed_s: float, now_s: float) -> None:
        """Count how long it has been in view without being seen again; so long, it was nothing."""
        x, y = suspect.place_m
        bearing = wrap(atan2(y - pose.y, x - pose.x) - pose.theta)
        if suspect.sightings > before.sightings:
            self._looked_s = 0.0
        elif abs(bearing) < _LOOK_CONE_RAD / 2.0 and pose_gap(pose, suspect) < _LOOK_M:
            self._looked_s += min(passed_s, 1.0)
        if self._looked_s > _LOOK_S or now_s - self._since_s > _VISIT_S:
            self.give_up()

    def _is_fresh(self, suspect: Suspect, now_s: float, pose: Pose2) -> bool:
        return (
            suspect.victim_id not in self._settled
            and now_s - suspect.last_seen_s < _FRESH_S
            and pose_gap(pose, suspect) < _REACH_M
        )


def pose_gap(pose: Pose2, suspect: Suspect) -> float:
    """Return how far (m) a suspect is from a pose, both in the map frame."""
    return hypot(suspect.place_m[0] - pose.x, suspect.place_m[1] - pose.y)
