"""A door hardly wider than the robot lies where it lies, not where cells of 0.2 m would have it."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.se2 import Pose2
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig

CELL_M = 0.05


def played(tmp_path, door_from_m, door_m):
    """Play one robot in two rooms of 3 by 4 m with a door between them, and return the arena at its end."""
    free = np.zeros((90, 140), bool)
    free[5:85, 5:65] = free[5:85, 69:129] = True
    free[round(door_from_m / CELL_M) : round((door_from_m + door_m) / CELL_M), 65:69] = True
    Image.fromarray(np.where(free[::-1], 254, 0).astype(np.uint8)).save(tmp_path / "plan.pgm")
    words = f"image: plan.pgm\nresolution: {CELL_M}\norigin: [0, 0, 0]\n"
    (tmp_path / "plan.yaml").write_text(words + "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
    agent = AgentConfig(
        planning=PlanningConfig(explore="nearest", communication="none"),
        deployment=DeploymentConfig(magazine=0),
    )
    scenario = ScenarioConfig(
        map=str(tmp_path / "plan.yaml"),
        robots=1,
        poses="truth",
        victims=0,
        base_tag=False,
        agent_config=agent,
    )
    ground = replace(ground_of(scenario), starts=(Pose2(1.5, 1.5, 0.0),))
    arena = Arena(ArenaConfig(scenario, "at once", limit_s=300.0, until=2.0, collide=True), ground)
    return arena, arena.play()


@pytest.mark.parametrize("door_m", [0.65, 0.7, 0.75])
@pytest.mark.parametrize("door_from_m", [2.0, 2.05, 2.1, 2.15])
def test_it_goes_through_and_comes_back(tmp_path, door_from_m, door_m):
    arena, result = played(tmp_path, door_from_m, door_m)
    (robot,) = arena.robots
    assert (robot.decision.activity, result.false_ends, result.times_stuck) == ("done", 0, 0)
    assert robot.decision.reason.endswith("I am at the base")
    assert result.coverage > 0.99
