"""In any small hall: a robot that says no edge is left has seen all there is, and none stands still."""

from dataclasses import replace

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.se2 import Pose2
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import Ground
from robots.sim.arena.result import leaves_a_hole
from robots.sim.arena.run import Arena
from robots.sim.generate import _connected
from robots.sim.scenario import ScenarioConfig
from robots.sim.score import observable
from robots.sim.starts import place_robots
from robots.sim.world import WorldError, world_of

CELL_M = 0.05
AGENT = AgentConfig(
    planning=PlanningConfig(explore="waymark"), deployment=DeploymentConfig(magazine=10, even_m=1.0)
)
BOXES = st.lists(
    st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.1, 2.5), st.floats(0.1, 0.8)), max_size=7
)


def hall(
    width_m: float, height_m: float, boxes: list[tuple[float, float, float, float]], seed: int
) -> Ground:
    """A walled hall with boxes in it: where, as shares of the sides, and how long and wide."""
    rows, columns = round(height_m / CELL_M), round(width_m / CELL_M)
    solid = np.zeros((rows, columns), bool)
    for k, (x, y, long_m, wide_m) in enumerate(boxes):
        sides = (long_m, wide_m) if k % 2 else (wide_m, long_m)
        row, column = int(y * rows), int(x * columns)
        solid[row : row + round(sides[1] / CELL_M), column : column + round(sides[0] / CELL_M)] = True
    solid[:2] = solid[-2:] = solid[:, :2] = solid[:, -2:] = True
    world = world_of(_connected(solid), CELL_M)
    radius_m = AGENT.body.radius_m
    starts = place_robots(world, 2, radius_m, "same", np.random.default_rng(seed))
    return Ground(world, observable(world, radius_m, 4.0), tuple(Pose2.from_array(row) for row in starts))


@settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.floats(4.0, 9.0), st.floats(3.5, 7.0), BOXES, st.integers(0, 1000), st.booleans())
def test_two_robots_in_each_others_way_end_when_all_is_seen(width_m, height_m, boxes, seed, tags_talk):
    try:
        ground = hall(width_m, height_m, boxes, seed)
    except WorldError:
        return  # no room for two
    planning = replace(AGENT.planning, communication="tags" if tags_talk else "none")
    told = ScenarioConfig(
        robots=2, seed=seed, poses="truth", victims=0, agent_config=replace(AGENT, planning=planning)
    )
    arena = Arena(ArenaConfig(told, "at once", reader_m=2.0, limit_s=600.0, until=2.0, collide=True), ground)
    result = arena.play()
    for robot in arena.robots:
        assert robot.decision.activity == "done"
        if robot.decision.reason.startswith("no edge of the unknown is left"):
            assert not leaves_a_hole(robot.seen, ground)
    assert result.times_stuck == 0
