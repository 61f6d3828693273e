"""Whether somebody can have come from one tag to another in the time: who cannot has met a copy of one."""

from __future__ import annotations

FASTEST_MPS = 5.0  # a run over the straight line, through walls: nobody in a building is faster
_LATE_S = 2.0  # a phone opens its page that much later at one tag than at another
_SDS = 3.0


def is_too_far(straight_m: float, sd_m: float, after_s: float) -> bool:
    """Say whether two tags are too far apart for somebody who read one ``after_s`` after the other.

    ``straight_m``: between their places on the map, known to ``sd_m`` of each other. False for a time below
    0: a clock that was set back proves nothing.
    """
    return after_s >= 0.0 and straight_m - _SDS * sd_m > FASTEST_MPS * (after_s + _LATE_S)
