"""The place that many runs share: the world, what can be seen of it, and where robots start."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from robots.se2 import Pose2
from robots.sim.hostile import HostileConfig
from robots.sim.scenario import ScenarioConfig, build_world
from robots.sim.score import observable
from robots.sim.starts import place_robots
from robots.sim.world import Mask, World


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """A world, the cells that can be seen from where robots get, and the team's starts in the world."""

    world: World
    observable: Mask
    starts: tuple[Pose2, ...]  # apart from each other

    @property
    def observable_m2(self) -> float:
        """Area that can be seen."""
        return float(self.observable.sum()) * self.world.resolution_m**2


def ground_of(config: ScenarioConfig) -> Ground:
    """Return the ground of a scenario: the same map, seed, rubble and laser give the same.

    Raises:
        WorldError, ScenarioError: it cannot be had; the message says why.
    """
    radius_m = config.agent_config.body.radius_m
    world, seen = _world(config.map, config.seed, radius_m, config.laser.range_max_m, config.hostile)
    starts = place_robots(
        world, config.robots, radius_m, config.start, np.random.default_rng([config.seed, 3])
    )
    return Ground(world, seen, tuple(Pose2.from_array(row) for row in starts))


@lru_cache(maxsize=2)
def _world(
    map_spec: str, seed: int, radius_m: float, range_m: float, hostile: HostileConfig
) -> tuple[World, Mask]:
    world = build_world(ScenarioConfig(map=map_spec, seed=seed, hostile=hostile))
    return world, observable(world, radius_m, range_m)
