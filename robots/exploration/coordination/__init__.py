"""One file for each way of sharing out the frontiers among the robots; ``COORDINATIONS`` names them."""

from robots.config import ConfigError
from robots.exploration.coordination.burgard import Burgard
from robots.exploration.coordination.exclusion import Exclusion
from robots.exploration.coordination.hungarian import Hungarian
from robots.exploration.coordination.node_counting import NodeCounting
from robots.exploration.coordination.original import Original
from robots.exploration.coordination.random import Random
from robots.exploration.coordination.simplified import Simplified
from robots.exploration.coordination.team import Coordination, Selfish, Team
from robots.exploration.coordination.voronoi import Voronoi

COORDINATIONS: dict[str, type[Coordination]] = {
    "none": Selfish,
    "random": Random,
    "simplified": Simplified,
    "original": Original,
    "burgard": Burgard,
    "exclusion": Exclusion,
    "hungarian": Hungarian,
    "voronoi": Voronoi,
    "node-counting": NodeCounting,
}


def coordination_of(name: str) -> Coordination:
    """Return a coordination by its name.

    Raises:
        ConfigError: there is none of that name.
    """
    if name not in COORDINATIONS:
        known = ", ".join(sorted(COORDINATIONS))
        raise ConfigError(f"planning.coordinate: no coordination is called {name!r}; known are {known}")
    return COORDINATIONS[name]()


__all__ = ["COORDINATIONS", "Coordination", "Team"]
