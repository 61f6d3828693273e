"""How far a robot got while its wheels slipped: no one knows, but not farther than they rolled.

One by one the trees' shares (``slip/tree.py``) decide little: on a patch where all wheels spin alike each is
just short of an alarm. So the floor is followed as a hidden Markov chain of grip and slippery patches. Both
classes count the same in a share s, hence an observation multiplies the odds of a patch by s / (1 - s), to
the power of its part of the window that the features look at: observations of one window say the same.
What comes later tells of what was before, for as long as ``_LAG_S``: a patch is known to begin and to end
only after a while, and the way made meanwhile is put right then.

All that the wheels roll on a patch counts alike: the share of it that the floor gives back lasts as long as
the patch. It is anything from none to all; wheels give themselves away the more, the more the floor takes, so
that being found out leaves it the density 2 (1 - s), with mean 1/3 and variance 1/18. Of L metres rolled

    way = L / 3,    variance = L^2 / 18
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import exp

from robots.estimation.slip.features import WINDOW_S

_SHARE, _VARIANCE = 1.0 / 3.0, 1.0 / 18.0
_BEGINS_S, _LASTS_S = 60.0, 3.0  # a patch is met once in so long, and lasts so long
_LAG_S, _GAP_S = 2.0, 0.5
_SURE = 0.99  # of no observation more is believed
_WATCHED = 0.1  # below so much nothing later makes a patch of it within the lag
_LEAST_M = 1e-6
UNKNOWN = 0.5  # the share that tells nothing


@dataclass(frozen=True, slots=True)
class Grip:
    """What of the way that the wheels rolled was driven, and the variance (m2) which that adds along it.

    Where an earlier step is put right with this one, the share is beyond 0 and 1.
    """

    share: float = 1.0
    variance_m2: float = 0.0


@dataclass(slots=True)
class _Step:
    stamp_s: float
    since_s: float
    rolled_m: float
    odds: float  # by which this step multiplies those of a patch
    slips: float  # the probability of a patch by all until this step
    on_patch: bool = False


class Slippage:
    """Follows what one robot's slip detector says."""

    def __init__(self) -> None:
        self._steps: deque[_Step] = deque()
        self._before_m = 0.0  # rolled on the patch on which the lag begins
        self._doubted_m = 0.0  # of the patch, as far as its variance was told
        self._owed_m = 0.0  # way to be put right with the next that is rolled

    def observe(self, stamp_s: float, rolled_m: float, share: float = UNKNOWN) -> Grip:
        """Take in how far the wheels rolled since the last observation, and its share of slippage."""
        rolled_m = abs(rolled_m)
        self._forward(stamp_s, rolled_m, share)
        way_m = rolled_m + self._owed_m + self._put_right()
        self._owed_m = 0.0
        patch_m = self._patch_m()
        doubted_m, self._doubted_m = self._doubted_m, max(self._doubted_m, patch_m) if patch_m else 0.0
        variance = _VARIANCE * max(patch_m**2 - doubted_m**2, 0.0)
        if rolled_m < _LEAST_M:
            self._owed_m = way_m
            return Grip(1.0, variance)
        return Grip(way_m / rolled_m, variance)

    @property
    def on_patch(self) -> bool:
        """Whether the last step was on a patch."""
        return bool(self._steps) and self._steps[-1].on_patch

    def _forward(self, stamp_s: float, rolled_m: float, share: float) -> None:
        slips, since_s = _LASTS_S / (_BEGINS_S + _LASTS_S), 0.0
        if self._steps and 0.0 <= stamp_s - self._steps[-1].stamp_s <= _GAP_S:
            since_s = stamp_s - self._steps[-1].stamp_s
            begins, ends = _changes(since_s)
            before = self._steps[-1].slips
            slips = before * (1.0 - ends) + (1.0 - before) * begins
        else:
            self._steps.clear()
            self._before_m = 0.0
        told = min(max(share, 1.0 - _SURE), _SURE)
        odds = (told / (1.0 - told)) ** min(since_s / WINDOW_S, 1.0)
        self._steps.append(
            _Step(stamp_s, since_s, rolled_m, odds, slips * odds / (slips * odds + 1.0 - slips))
        )
        while self._steps[0].stamp_s < stamp_s - _LAG_S:
            gone = self._steps.popleft()
            self._before_m = self._before_m + gone.rolled_m if gone.on_patch else 0.0

    def _put_right(self) -> float:
        """Say of every step of the lag, by all that is known now, where it was; return what that adds."""
        if not any(step.on_patch or step.slips > _WATCHED for step in self._steps):
            return 0.0
        added_m, odds = 0.0, 1.0  # the odds of a patch by what comes after a step
        for step in reversed(self._steps):
            smoothed = step.slips * odds
            on_patch = smoothed > 1.0 - step.slips
            if on_patch != step.on_patch:
                added_m += (_SHARE - 1.0) * step.rolled_m * (1.0 if on_patch else -1.0)
                step.on_patch = on_patch
            begins, ends = _changes(step.since_s)
            odds *= step.odds
            odds = ((1.0 - ends) * odds + ends) / (begins * odds + 1.0 - begins)
        return added_m

    def _patch_m(self) -> float:
        """Return how far the wheels rolled on the longest patch that the lag touches."""
        longest_m = here_m = self._before_m
        for step in self._steps:
            here_m = here_m + step.rolled_m if step.on_patch else 0.0
            longest_m = max(longest_m, here_m)
        return longest_m


def _changes(since_s: float) -> tuple[float, float]:
    """Return the probabilities that a patch began, and that one ended, within a time."""
    return 1.0 - exp(-since_s / _BEGINS_S), 1.0 - exp(-since_s / _LASTS_S)
