"""Multi-criteria decision making (Amigoni 2013 eq. 2): a Choquet integral over area, way, report and battery.

The battery is the same for all of a robot's candidates, so the printed relative scale would be 0 / 0: what is
left of it is taken as it is. A criterion in which all candidates are alike speaks for all of them.
"""

from __future__ import annotations

import numpy as np

from robots.exploration.frontiers import Frontier
from robots.exploration.strategies.aojrf import areas_of, beyond, chances_of, safe_candidates
from robots.exploration.strategies.choquet import Capacity
from robots.exploration.strategies.sight import Sight
from robots.exploration.strategy import ExplorationView, ways_of
from robots.se2 import Array

WEIGHTS = {  # as printed
    "A": 0.4, "d": 0.3, "P": 0.05, "b": 0.25, "Ad": 0.75, "AP": 0.55, "Ab": 0.55, "dP": 0.4, "db": 0.32,
    "Pb": 0.28, "AdP": 0.9, "Adb": 0.8, "APb": 0.85, "dPb": 0.4,
}  # fmt: skip
CAPACITY = Capacity("AdPb", {frozenset(group): weight for group, weight in WEIGHTS.items()})


class Mcdm:
    """Weighs groups of criteria together: a place near and large counts more than both for themselves."""

    keeps_goals = True  # "go to their destination locations and start again"

    def __init__(self) -> None:
        self._sight = Sight()

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the middles of the free ground beyond each boundary of the safe."""
        return safe_candidates(view, self._sight)

    def worths(self, view: ExplorationView) -> Array:
        """Return u(p, r) of eq. (2), between 0 and 1."""
        battery = np.full(len(view.frontiers), min(max(view.battery, 0.0), 1.0))
        criteria = (relative(areas_of(view)), 1.0 - relative(ways_of(view), 0.0), relative(chances_of(view)))
        return CAPACITY.integral(np.column_stack([*criteria, battery]))

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return what there is to gain."""
        return beyond(view, index)


def relative(values: Array, where_alike: float = 1.0) -> Array:
    """Return values (n,) between that of the least, 0, and of the greatest, 1."""
    spread = values.max(initial=-np.inf) - values.min(initial=np.inf)
    if not spread > 0.0:
        return np.full(len(values), where_alike)
    scaled: Array = (values - values.min()) / spread
    return scaled
