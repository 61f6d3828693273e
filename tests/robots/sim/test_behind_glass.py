"""A live robot, with poses that it estimates, among glass: done when all is seen, not when all seems so."""

import numpy as np

from robots.agent import RobotAgent, merge_commands
from robots.config import AgentConfig, PlanningConfig
from robots.exploration.last_looks import BEHIND_GLASS
from robots.sim import simulation as sim
from robots.sim.arena.ground import Ground
from robots.sim.arena.result import leaves_a_hole
from robots.sim.pilots import DirectPilot
from robots.sim.scenario import ScenarioConfig
from robots.sim.score import observable
from robots.sim.world import World

HUT = """
############################
#..........................#
#..........................#
#..........................#
#..........................#
#.......###########........#
#.......#....#....g........#
#.......#....#....g........#
#.......#....#....g........#
#............#....g........#
#............#....g........#
#............#....g........#
#.......#....#....g........#
#.......#.........g........#
#.......#.........g........#
#.......#.........g........#
#.......###########........#
#..........................#
#..........................#
#..........................#
#..........................#
############################
"""


def test_a_robot_goes_into_the_room_that_it_saw_through_glass_alone(draw, monkeypatch):
    """Its own map shows the room as free: one that trusted it was done with 2.2 m2 unseen there."""
    coarse = draw(HUT, 0.25)
    world = World(np.kron(coarse.cells, np.ones((5, 5), np.uint8)), (0.0, 0.0), 0.05)
    monkeypatch.setattr(sim, "build_world", lambda config: world)
    alone = AgentConfig(planning=PlanningConfig(communication="none"))
    mission = sim.Simulation(ScenarioConfig(robots=1, seed=2, victims=0, agent_config=alone))
    agent, why = RobotAgent("r1", mission.agent_of("r1")), {}
    pilot = DirectPilot(agent, merge_commands, lambda _, update: why.update({update.activity: update.reason}))
    reasons = set()
    while mission.clock_s < 900.0 and "done" not in why:
        mission.apply({"r1": pilot.decide(mission.advance()["r1"], mission.clock_s)})
        reasons.add(why.get("exploring", "").partition(" m to ")[2])
    assert "done" in why
    assert BEHIND_GLASS in reasons
    reach_m = mission.config.laser.range_max_m
    ground = Ground(world, observable(world, alone.body.radius_m, reach_m), mission.starts)
    assert not leaves_a_hole(mission.seen, ground)
