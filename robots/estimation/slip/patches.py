"""How far a robot got while its wheels slipped: no one knows, but not farther than they rolled.

One by one the detector's alarms miss half of a slippery patch and come now and then where there is none.
Where a fifth of a second's observations alarm, the robot is on a patch, until a second passes without any.
All that the wheels roll there counts alike: the share s of it that the floor gives back lasts as long as the
patch. Before, it is anything from none to all; wheels alarm the more, the more the floor takes away, so that
alarms leave it the density 2 (1 - s), with mean 1/3 and variance 1/18. Of L metres rolled on a patch

    way = L / 3,    variance = L^2 / 18
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

_WINDOW_S = 1.0
_ALARMS, _FEWEST = 0.2, 2  # of the observations in the window
_SHARE, _VARIANCE = 1.0 / 3.0, 1.0 / 18.0


@dataclass(frozen=True, slots=True)
class Grip:
    """What of the way that the wheels rolled was driven, and the variance (m2) which that adds along it."""

    share: float = 1.0
    variance_m2: float = 0.0


class Slippage:
    """Follows the alarms of one robot's slip detector."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, bool]] = deque()  # stamp, alarm
        self._rolled_m = 0.0  # on this patch

    def observe(self, stamp_s: float, rolled_m: float, alarm: bool) -> Grip:
        """Take in how far the wheels rolled since the last observation, and whether this one alarmed."""
        self._seen.append((stamp_s, alarm))
        while self._seen[0][0] <= stamp_s - _WINDOW_S:
            self._seen.popleft()
        alarms = sum(alarmed for _, alarmed in self._seen)
        if alarms == 0 or (not self._rolled_m and alarms < max(_FEWEST, _ALARMS * len(self._seen))):
            self._rolled_m = 0.0
            return Grip()
        before_m, self._rolled_m = self._rolled_m, self._rolled_m + abs(rolled_m)
        return Grip(_SHARE, _VARIANCE * (self._rolled_m**2 - before_m**2))
