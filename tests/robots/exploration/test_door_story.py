"""Two rooms off a corridor: what the first robot leaves in the tag at a door sends the second to the next.

The simulator's own tags, chips and seals; the robots never hear each other.
"""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from robots.agent import RobotAgent, merge_commands
from robots.config import AgentConfig, AntennaConfig, DeploymentConfig
from robots.orders import RobotOrder
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.tags.memory import CLOSED
from robots.tags.sealed import open_memory

CELL_M = 0.05
DOOR_A_M, DOOR_B_M = 4.5, 9.0  # along the corridor
ROOMS_FROM_M = 1.7  # across it
AGENT = AgentConfig(antenna=AntennaConfig(radius_m=0.4), deployment=DeploymentConfig(magazine=0))


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A corridor of 12 m by 1.3 m; on one side of it rooms A and B, 4 m by 5 m, with doors 0.9 m wide."""
    free = np.zeros((140, 250), bool)

    def carve(x0, y0, x1, y1):
        free[round(y0 / CELL_M) : round(y1 / CELL_M), round(x0 / CELL_M) : round(x1 / CELL_M)] = True

    carve(0.2, 0.2, 12.2, 1.5)
    for door in (DOOR_A_M, DOOR_B_M):
        carve(door - 0.45, 1.5, door + 0.45, ROOMS_FROM_M)
        carve(door - 2.0, ROOMS_FROM_M, door + 2.0, ROOMS_FROM_M + 5.0)
    folder = tmp_path_factory.mktemp("plan")
    Image.fromarray(np.where(free[::-1], 254, 0).astype(np.uint8)).save(folder / "plan.pgm")
    words = f"image: plan.pgm\nresolution: {CELL_M}\norigin: [0, 0, 0]\n"
    (folder / "plan.yaml").write_text(words + "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return str(folder / "plan.yaml")


class Visit:
    """One robot, from the near end of the corridor on; ``rooms`` in whose doors it stood, in order."""

    def __init__(self, plan, name, explore="waymark", chip=None, tag=True):
        config = ScenarioConfig(
            map=plan,
            robots=1,
            poses="truth",
            victims=0,
            base_tag=False,
            agent_config=AGENT,
            explore=(("*", explore),),
        )
        self.simulation = Simulation(config)
        self.simulation.bodies.poses[0] = (1.0, 0.85, 0.0)
        if tag:
            self.simulation.tags.drop("DOOR-A", DOOR_A_M - 1.0, 0.85)
        if chip is not None:
            self.simulation.tags.named("DOOR-A").chip = chip
        self.agent = RobotAgent(name, config.agent_of("r1"))
        self.rooms, self.reasons = [], []
        self.order = None

    @property
    def door_tag(self):
        return self.simulation.tags.named("DOOR-A")

    def play(self, seconds, until):
        for _ in range(round(5 * seconds)):
            *before, last = self.simulation.advance()["r1"]
            if self.order is not None:
                last, self.order = replace(last, orders=(self.order,)), None
            updates = [self.agent.step(observation) for observation in (*before, last)]
            self.reasons.append(updates[-1].reason)
            self.simulation.apply({"r1": Order(merge_commands(updates))})
            x, y, _ = self.simulation.bodies.poses[0]
            room = "A" if x < (DOOR_A_M + DOOR_B_M) / 2.0 else "B"
            if y > ROOMS_FROM_M - 0.3 and room not in self.rooms:
                self.rooms.append(room)
            if until(self):
                return
        raise AssertionError(f"did not come to it: {self.rooms}, {self.reasons[-1]}")


def tells_of_a(visit):
    """Whether the tag says by now that the ground beyond the door is covered and closed."""
    says = open_memory(visit.door_tag.memory, "DOOR-A", b"")
    return says.trusted and int((says.memory.cells == CLOSED).sum()) >= 18 and visit.rooms == ["A"]


@pytest.fixture(scope="module")
def first(plan):
    visit = Visit(plan, "r1", explore="nearest")
    visit.play(60.0, lambda visit: visit.simulation.bodies.poses[0][1] > ROOMS_FROM_M + 1.3)
    visit.order = RobotOrder("o1", "return", "Ann")  # over the tag, whatever is left to explore
    visit.play(60.0, tells_of_a)
    return visit


def test_the_first_robot_takes_the_first_door_and_leaves_word_at_it(first):
    assert first.rooms[0] == "A"
    assert len(first.simulation.tags.tags) == 1


def test_the_second_goes_on_to_the_next_door(plan, first):
    second = Visit(plan, "r2", chip=first.door_tag.chip)
    second.play(120.0, lambda visit: visit.rooms)
    assert second.rooms == ["B"]
    assert any("m² that nobody has told of" in reason for reason in second.reasons)


def test_without_word_it_would_have_taken_the_first_door(plan):
    alone = Visit(plan, "r2", tag=False)
    alone.play(120.0, lambda visit: visit.rooms)
    assert alone.rooms == ["A"]


def test_in_the_end_it_looks_into_the_other_room_too(plan, first):
    second = Visit(plan, "r2", chip=first.door_tag.chip)
    second.play(240.0, lambda visit: len(visit.rooms) == 2)
    assert second.rooms == ["B", "A"]
