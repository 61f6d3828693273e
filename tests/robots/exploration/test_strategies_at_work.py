"""Short missions of every strategy in the simulator, with tags, true poses and two robots."""

import pytest

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.exploration.strategies import STRATEGIES
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig

WAYS = [(name, 0.0) for name in STRATEGIES] + [("waymark", 4.0)]


@pytest.mark.parametrize(("name", "local_map_m"), WAYS)
def test_a_mission_ends_without_an_error_and_sees_ground(name, local_map_m):
    result = run(
        ScenarioConfig(
            map="office:60",
            robots=2,
            minutes=0.4,
            seed=2,
            poses="truth",
            victims=0,
            agent_config=AgentConfig(
                planning=PlanningConfig(explore=name, local_map_m=local_map_m),
                deployment=DeploymentConfig(even_m=1.0),
            ),
        )
    )
    assert result.score.coverage > 0.3
    assert result.score.distance_m > 4.0
    assert result.tags_dropped > 1
