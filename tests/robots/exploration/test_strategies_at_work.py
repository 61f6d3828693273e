"""Short missions of every strategy in the simulator, with tags, true poses and two robots."""

import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.exploration.coordination import COORDINATIONS
from robots.exploration.strategies import STRATEGIES
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation

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


@pytest.mark.parametrize("name", COORDINATIONS)
def test_robots_that_share_out_the_ground_see_a_building_together(name):
    planning = PlanningConfig(explore="mcdm", coordinate=name, communication="full")
    result = run(
        ScenarioConfig(
            map="office:60",
            robots=3,
            minutes=0.5,
            seed=2,
            poses="truth",
            start="spread",
            victims=0,
            agent_config=AgentConfig(planning=planning, deployment=DeploymentConfig(even_m=1.0)),
        )
    )
    assert result.score.coverage > 0.6


@pytest.mark.parametrize(
    ("name", "local_map_m"), [("kleiner-printed", 0.0), ("ziparo", 0.0), ("waymark", 4.0)]
)
def test_a_restored_agent_goes_on_as_if_nothing_had_happened(name, local_map_m):
    planning = PlanningConfig(explore=name, local_map_m=local_map_m)
    config = AgentConfig(planning=planning, deployment=DeploymentConfig(even_m=1.0))
    scenario = ScenarioConfig(map="office:60", robots=1, seed=2, victims=0, agent_config=config)
    simulation, agent = Simulation(scenario), RobotAgent("r1", scenario.agent_of("r1"))
    restored = None
    for period in range(40):
        for observation in simulation.advance()["r1"]:
            update = agent.step(observation)
            if restored is not None:
                again = restored.step(observation)
                assert (again.command, again.reason) == (update.command, update.reason)
        if period == 20:
            restored = RobotAgent.restore(agent.snapshot())
        simulation.apply({"r1": Order(update.command)})
