"""Robots led by the server hear each other through it, and the log holds what they heard."""

import base64
import json

import pytest

from robots import codec
from robots.config import AgentConfig, PlanningConfig
from robots.exploration.team.team_message import decode_message
from robots.sim.live import changes
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.sim.wire import command_from_wire, observation_to_wire, pose_to_wire
from robots.types import Observation
from server.cli.main import run

TALKING = AgentConfig(planning=PlanningConfig(communication="full", coordinate="exclusion"))


def drive(line, simulation, periods, sent=None):
    """Play so many control periods through the server; return the last replies."""
    replies = {}
    for _ in range(periods):
        for name, batch in simulation.advance().items():
            wires = [observation_to_wire(observation) for observation in batch]
            replies[name] = line.send(wires, name)
            if sent is not None:
                sent[name] = wires
        orders = {n: Order(command_from_wire(r["command"]), r["stop"]) for n, r in replies.items()}
        simulation.apply(orders)
    return replies


def registered(line, simulation, agent="server"):
    for name, start in zip(simulation.config.robot_ids, simulation.starts, strict=True):
        place = {**pose_to_wire(start), "sd_m": 0.05, "sd_rad": 0.02}
        told = changes(simulation.config.agent_of(name), AgentConfig())
        assert line.register(name, config=told, start_pose=place, agent=agent).status_code == 201


def logged(line, name):
    bodies = line.control.sql(
        f"SELECT body FROM observations WHERE mission_id = '{line.mission_id}' AND robot_id = '{name}'"
        " ORDER BY seq"
    )
    return [codec.decode(body, Observation) for (body,) in bodies]


def test_what_one_says_the_others_hear_and_a_replay_too(tmp_path, make_control, wait_until, capsys):
    line = make_control(tmp_path / "data", snapshot_every=30, reply_s=120.0).open("school")
    simulation = Simulation(ScenarioConfig(map="office:80", robots=2, seed=3, agent_config=TALKING))
    registered(line, simulation)
    sent = {}
    replies = drive(line, simulation, 20, sent)
    assert all(reply["command"]["say"] is None for reply in replies.values())  # the others know by now
    assert line.call("POST", "/stop", {"robots": ["r1"]}).json() == {"stopped": ["r1"]}
    replies = drive(line, simulation, 5, sent)
    assert replies["r1"]["stop"]
    assert replies["r1"]["command"]["linear_mps"] == 0.0
    line.call("POST", "/resume", {"robots": ["r1"]})
    drive(line, simulation, 20, sent)
    line.send(sent["r2"], "r2")  # once more: what the server added makes no other robot of it
    assert line.events("name_shared") == []
    for name, other in (("r1", "r2"), ("r2", "r1")):
        heard = [decode_message(data) for observation in logged(line, name) for data in observation.heard]
        assert {message.robot_id for message in heard} == {other}
        numbers = [message.number for message in heard]
        assert numbers == sorted(set(numbers))
        assert len(numbers) >= 7
        assert any(patch.origin == other for message in heard for patch in message.patches)
    wait_until(lambda: len(line.control.sql("SELECT DISTINCT robot_id FROM agent_snapshots")) == 2)
    line.control.stop()
    out = tmp_path / "school.log"
    assert (
        run(["export", "log", "school", "--data", str(tmp_path / "data"), "--out", str(out), "--json"]) == 0
    )
    capsys.readouterr()
    assert run(["replay", "log", str(out), "--json"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["bit_equal"] == {"r1": True, "r2": True}
    assert min(replayed["updates_compared"].values()) > 25


def test_a_robot_with_a_radio_says_it_itself_and_brings_what_it_heard(tmp_path, make_control):
    line = make_control(tmp_path, reply_s=120.0).open()
    told = AgentConfig(planning=PlanningConfig(communication="radio"))
    simulation = Simulation(ScenarioConfig(map="office:80", robots=2, seed=3, agent_config=told))
    registered(line, simulation)
    said = []
    for _ in range(12):
        replies = drive(line, simulation, 1)
        said += [r["command"]["say"] for r in replies.values() if r["command"]["say"] is not None]
    senders = {decode_message(base64.b64decode(text)).robot_id for text in said}
    assert senders == {"r1", "r2"}
    heard = {decode_message(data).robot_id for o in logged(line, "r1") for data in o.heard}
    assert heard == {"r2", "base"}


@pytest.mark.parametrize("heard", [["not base64!"], ["A" * 50_000], "text", [""] * 300])
def test_what_cannot_be_a_message_is_refused(line, heard):
    code, kind, field = line.refused_post([{"seq": 0, "stamp_s": 0.0, "heard": heard}])
    assert (code, kind) == (422, "invalid")
    assert field.startswith("observations.0.heard")


def test_a_garbled_message_is_doubted_in_words(line):
    garbled = base64.b64encode(b"WTM\x01 but no more").decode()
    line.call("POST", "/robots", {"robot_id": "r2", "start_pose": line.words["start_pose"],
                                  "config": {"planning": {"communication": "full"}}})  # fmt: skip
    for seq in range(3):
        line.send([{"seq": seq, "stamp_s": 0.1 * seq, "heard": [garbled]}], "r2")
    texts = [event["text"] for event in line.events("tag_doubtful")]
    assert texts == ["r2: a message of the team was put aside: it was damaged on the way"]
