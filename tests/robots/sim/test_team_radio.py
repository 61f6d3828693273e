"""Robots that talk: who hears whom, what they make of it, and that a replay hears the same."""

from dataclasses import replace
from itertools import count, islice

import numpy as np
import pytest

from robots.agent import RobotAgent, merge_commands
from robots.codec import decode, encode
from robots.config import AgentConfig, PlanningConfig
from robots.exploration.team.gossip import Gossip
from robots.exploration.team.team_message import decode_message, encode_message
from robots.orders import Methods, RobotOrder
from robots.outputs import write_map
from robots.se2 import Pose2
from robots.sim.runner import run
from robots.sim.scenario import RadioCut, ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.sim.team_radio import BASE, TeamRadio
from robots.team import TeamGrid
from robots.types import AgentUpdate

FREE, WALL = 0, 100


@pytest.fixture
def map_of(tmp_path):
    """A function that writes a map of free rectangles (x0, y0, x1, y1), metres, and returns its file."""

    def write(*rooms, width_m=30.0, height_m=14.0):
        cells = np.full((round(height_m / 0.1), round(width_m / 0.1)), WALL, np.int8)
        for x0, y0, x1, y1 in rooms:
            cells[round(y0 * 10) : round(y1 * 10), round(x0 * 10) : round(x1 * 10)] = FREE
        write_map(tmp_path, TeamGrid(cells, (0.0, 0.0), 0.1, 0))
        return str(tmp_path / "map.yaml")

    return write


def talking(map_file, communication, coordinate="hungarian", **more):
    planning = PlanningConfig(explore="nearest", coordinate=coordinate, communication=communication)
    told = AgentConfig(planning=planning)
    return ScenarioConfig(
        map=map_file, robots=2, victims=0, poses="truth", agent_config=told, **({"minutes": 0.5} | more)
    )


TWO_ROOMS = (1.0, 1.0, 9.0, 9.0), (10.0, 1.0, 18.0, 9.0)  # with a wall of a metre between them


def message_of(name="r1", to=None):
    """What a robot says that has seen the first tile of the ground, to another one that it has heard."""
    speaker = Gossip(name)
    speaker.ground.note(name, {(0, 0): bytes([0b01010101]) * 256})
    if to is not None:
        speaker.hear(0.0, to.say(0.0, 0.0, Pose2(), None))
    return encode_message(speaker.say(0.0, 0.0, Pose2(), None))


def heard(radio, index, poses, clock_s=0.0):
    messages = (decode_message(data) for data in radio.take(index, poses, clock_s))
    return [message.robot_id for message in messages if message.robot_id != BASE]


def at(*places):
    return np.array([(x, y, 0.0) for x, y in places])


@pytest.mark.parametrize(
    ("kinds", "poses", "hears"),
    [
        ("full", at((2.0, 2.0), (17.0, 8.0)), True),
        ("radio", at((2.0, 2.0), (8.0, 8.0)), True),
        ("radio", at((8.5, 5.0), (10.5, 5.0)), True),  # through one wall
        ("radio", at((1.5, 1.5), (17.5, 8.5)), False),  # and too far through one
        ("tags", at((2.0, 2.0), (2.5, 2.0)), False),
        ("none", at((2.0, 2.0), (2.5, 2.0)), False),
    ],
)
def test_who_hears_whom(map_of, kinds, poses, hears):
    config = talking(map_of(*TWO_ROOMS), kinds)
    simulation = Simulation(config)
    radio = TeamRadio(config, simulation.world, (100.0, 100.0))
    radio.say(0, message_of(), poses, 0.0)
    assert heard(radio, 1, poses) == (["r1"] if hears else [])
    assert heard(radio, 1, poses) == []
    assert heard(radio, 0, poses) == []


def test_robots_that_are_told_to_talk_on_the_way_hear_each_other():
    simulation = Simulation(replace(talking("office:80", "tags", seed=3), start="spread"))
    agents = {name: RobotAgent(name, simulation.agent_of(name)) for name in ("r1", "r2")}
    told, heard_by = RobotOrder("o1", "methods", methods=Methods(communication="radio")), set()
    for period in range(60):
        orders = {}
        for name, observations in simulation.advance().items():
            heard_by |= {name for observation in observations if observation.heard}
            *_, last = observations
            updates = [agents[name].step(observation) for observation in observations[:-1]]
            updates.append(agents[name].step(replace(last, orders=(told,) if period == 5 else ())))
            orders[name] = Order(merge_commands(updates))
        assert period > 5 or not heard_by
        simulation.apply(orders)
    assert heard_by == {"r1", "r2"}


def test_nothing_gets_to_or_from_a_robot_in_silence(map_of):
    poses = at((2.0, 2.0), (3.0, 2.0))
    for name in ("r1", "r2"):
        config = talking(map_of(*TWO_ROOMS), "full", radio_cuts=(RadioCut(name, 0.0, 5.0),))
        radio = TeamRadio(config, Simulation(config).world, (2.0, 2.0))
        radio.say(0, message_of(), poses, 1.0)
        assert heard(radio, 1, poses, 1.0) == []
        radio.say(0, message_of(), poses, 5.0)
        assert heard(radio, 1, poses, 5.0) == ["r1"]


def test_the_base_knows_what_somebody_carried_to_it(map_of):
    """r1 is out of reach for ever; r2 hears it, drives to the base, and there tells of both."""
    config = talking(map_of(*TWO_ROOMS), "radio", team_radio_m=6.0)
    simulation = Simulation(config)
    radio = TeamRadio(config, simulation.world, (1.5, 1.5))
    everywhere = simulation.world.free
    assert radio.known_at_base(everywhere) == 0.0
    far, carrier = at((17.0, 8.0), (12.0, 8.0)), Gossip("r2")
    radio.say(0, message_of(to=carrier), far, 0.0)
    (carried,) = radio.take(1, far, 0.0)
    assert radio.known_at_base(everywhere) == 0.0
    carrier.hear(0.0, decode_message(carried))
    for clock_s in range(1, 60):
        home = at((17.0, 8.0), (2.0, 2.0))
        for data in radio.take(1, home, float(clock_s)):
            carrier.hear(float(clock_s), decode_message(data))
        radio.say(1, encode_message(carrier.say(float(clock_s), 0.0, Pose2(), None)), home, float(clock_s))
    assert carrier.ground.known["r1"] == 1
    expected = 3.2 * 3.2 - (1.0 + 1.0) * 3.2 + 1.0  # of the tile, what lies in the room
    assert radio.known_at_base(everywhere) * everywhere.sum() * 0.01 == pytest.approx(expected, rel=0.1)


def test_two_that_hear_each_other_take_the_two_arms_of_a_junction(map_of):
    stem, arms = (14.0, 1.0, 16.0, 10.0), (1.0, 10.0, 29.0, 12.0)
    file = map_of(stem, arms)
    below = (s for s in count() if all(p.y < 6.0 for p in Simulation(talking(file, "full", seed=s)).starts))
    apart_m = {"full": 0.0, "none": 0.0}
    for seed in islice(below, 3):
        for kind in apart_m:
            result = run(talking(file, kind, seed=seed))
            first, last = sorted(robot.truths[-1, 0] for robot in result.robots)
            apart_m[kind] += (last - first) / 3.0
            assert (result.known_at_base is None) == (kind == "none")
            assert kind == "none" or (first < 13.0 and last > 17.0)  # in either arm
    assert apart_m["full"] > 2.0 * apart_m["none"]


class Noting(RobotAgent):
    """An agent that keeps its log."""

    def __init__(self, robot_id, config):
        super().__init__(robot_id, config)
        self.log, self.updates = [], []

    def step(self, observation):
        update = super().step(observation)
        self.log.append(observation)
        self.updates.append(encode(update))
        return update


def played(config):
    agents = {}

    def factory(robot_id, told):
        agents[robot_id] = Noting(robot_id, told)
        return agents[robot_id]

    return run(config, factory), agents


@pytest.mark.parametrize("poses", ["truth", "slam"])
def test_a_replay_of_the_log_hears_and_does_the_same(poses):
    config = talking("office:80", "full", "burgard", seed=3)
    _, agents = played(replace(config, poses=poses, minutes=0.25))
    for name, agent in agents.items():
        assert sum(len(observation.heard) for observation in agent.log) > 10
        again = RobotAgent(name, agent.config)
        half = len(agent.log) // 2
        for k, observation in enumerate(agent.log):
            if k == half:
                again = RobotAgent.restore(again.snapshot())
            assert encode(again.step(observation)) == agent.updates[k]
        deaf = RobotAgent(name, agent.config)
        assert [encode(deaf.step(replace(o, heard=()))) for o in agent.log] != agent.updates


def test_by_radio_ground_is_shared_when_they_meet_and_not_before(map_of):
    """Two rooms a long way apart: each learns of the other's only where the corridor brings them together."""
    west, east, way = (1.0, 1.0, 7.0, 5.0), (23.0, 1.0, 29.0, 5.0), (3.0, 2.0, 27.0, 3.5)
    config = talking(map_of(west, east, way), "radio", start="spread", minutes=1.5, team_radio_m=5.0, seed=1)
    result, agents = played(config)
    for name, other in (("r1", "r2"), ("r2", "r1")):
        mine, theirs = (
            next(robot.truths for robot in result.robots if robot.robot_id == each) for each in (name, other)
        )
        away = np.hypot(*(mine[:, :2] - theirs[:, :2]).T)
        met = [
            k
            for k, observation in enumerate(agents[name].log)
            if any(decode_message(data).robot_id == other for data in observation.heard)
        ]
        assert away[0] > 10.0
        assert met
        assert (away[met] < 5.0 + 1.0).all()
        assert met[0] >= np.flatnonzero(away < 5.0)[0]
        tiles = [
            tile
            for observation in agents[name].log
            for data in observation.heard
            for patch in decode_message(data).patches
            for tile in patch.tiles
            if patch.origin == other
        ]
        columns = {tile.column for tile in tiles}
        far_end = theirs[0, 0] / 3.2
        assert any(abs(column - far_end) < 1.5 for column in columns)  # what it saw first is told too


def test_a_robot_whose_start_nobody_surveyed_says_so_and_explores_alone():
    config = talking("office:80", "full")
    _, agents = played(replace(config, minutes=0.1))
    alone = RobotAgent("r1", replace(agents["r1"].config, start=()))
    updates = [alone.step(observation) for observation in agents["r1"].log]
    doubts = [text for update in updates for text in update.doubts]
    assert len(doubts) == 1
    assert "was not surveyed" in doubts[0]
    assert all(update.command.say is None for update in updates)
    assert updates[-1].activity == "exploring"


def test_what_is_no_message_is_doubted_once_and_harms_nothing():
    config = talking("office:80", "full")
    _, agents = played(replace(config, minutes=0.1))
    log = agents["r1"].log
    garbled = RobotAgent("r1", agents["r1"].config)
    noise = (b"", b"WTM\x01 not quite", bytes(100_000))
    updates = [garbled.step(replace(o, heard=(*noise, *o.heard, *o.heard))) for o in log]
    assert [u.command for u in updates] == [decode(u, AgentUpdate).command for u in agents["r1"].updates]
    doubts = [text for update in updates for text in update.doubts]
    assert len(doubts) == 3
    assert all(text.startswith("a message of the team was put aside: it ") for text in doubts)
