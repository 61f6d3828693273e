"""Where a robot was at a moment: its steps, thinned, whatever the order they arrive in."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from math import floor, hypot, isfinite

from robots.se2 import Pose2

_BUCKET_S = 0.5
_MOST = 20_000  # steps kept: some hours; then every bucket becomes two times as long
_OUTSIDE_S = 1.0  # so long before the first and after the last step a robot is still known
_SPEED_MPS = 0.5
_STEP_SD_M = 0.03  # of a place against the anchor a few metres back

_Step = tuple[int, float, int, float, float, float]  # seq, stamp, anchor and the base in its frame


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """The base in the frame of a pose vertex, with the standard deviation of its place in metres."""

    anchor: int
    anchor_from_base: Pose2
    sd_m: float


class History:
    """The first step in each span of time; a function of the set of steps, bounded in memory."""

    def __init__(self) -> None:
        self._bucket_s = _BUCKET_S
        self._steps: dict[int, _Step] = {}
        self._sorted: list[_Step] | None = None

    def put(self, seq: int, stamp_s: float, anchor: int, anchor_from_base: Pose2) -> None:
        """Take in a step; one that is not finite is left out."""
        place = anchor_from_base
        if not all(map(isfinite, (stamp_s, place.x, place.y, place.theta))):
            return
        step = (seq, stamp_s, anchor, place.x, place.y, place.theta)
        if not self._keep(step):
            return
        while len(self._steps) > max(_MOST, 2):
            steps, self._steps = list(self._steps.values()), {}
            self._bucket_s *= 2.0
            for each in steps:
                self._keep(each)

    def at(self, stamp_s: float) -> Whereabouts | None:
        """Return where the robot was, between the steps before and after; None where nothing is near."""
        if self._sorted is None:
            self._sorted = sorted(self._steps.values(), key=lambda step: (step[1], step[0]))
        steps = self._sorted
        if not steps or not isfinite(stamp_s):
            return None
        k = bisect_right(steps, stamp_s, key=lambda step: step[1])
        if k == 0 or k == len(steps):
            near = steps[0] if k == 0 else steps[-1]
            gap_s = abs(near[1] - stamp_s)
            return _whereabouts(near, _SPEED_MPS * gap_s) if gap_s <= _OUTSIDE_S else None
        before, after = steps[k - 1], steps[k]
        since_s, until_s = stamp_s - before[1], after[1] - stamp_s
        within_m = 0.3 * _SPEED_MPS * min(since_s, until_s)
        if before[2] != after[2]:  # an anchor lies between them
            return _whereabouts(before if since_s <= until_s else after, 2.0 * within_m)
        a, b = Pose2(*before[3:]), Pose2(*after[3:])
        share = since_s / (since_s + until_s) if since_s > 0.0 else 0.0
        moved = a.between(b)
        pose = a @ Pose2(share * moved.x, share * moved.y, share * moved.theta)
        return Whereabouts(before[2], pose, hypot(_STEP_SD_M, min(within_m, 0.5 * hypot(moved.x, moved.y))))

    def _keep(self, step: _Step) -> bool:
        key = floor(step[1] / self._bucket_s)
        known = self._steps.get(key)
        if known is not None and known <= step:
            return False
        self._steps[key] = step
        self._sorted = None
        return True


def _whereabouts(step: _Step, moved_m: float) -> Whereabouts:
    return Whereabouts(step[2], Pose2(*step[3:]), hypot(_STEP_SD_M, moved_m))
