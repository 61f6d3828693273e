"""Orders to robots: issued, delivered with an observation, done or failed; and methods changed live."""

import time
from math import cos, sin

import httpx
import pytest

from robots import codec
from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.orders import Methods
from robots.overrides import override
from robots.sim.wire import observation_from_wire, order_from_wire
from robots.types import Observation


def order(line, kind, robot_id="r1", **place):
    response = line.call("POST", f"/robots/{robot_id}/orders", {"kind": kind, **place})
    assert response.status_code == 201, response.text
    return response.json()


def states(line, robot_id="r1"):
    return [(o["kind"], o["state"]) for o in line.get(f"/robots/{robot_id}/orders")["orders"]]


def eventually(line, expected):
    for _ in range(100):
        if states(line) == expected:
            return
        time.sleep(0.05)
    assert states(line) == expected


def stored(line, control) -> list[Observation]:
    rows = control.sql(f"SELECT body FROM observations WHERE mission_id = '{line.mission_id}' ORDER BY seq")
    return [codec.decode(body, Observation) for (body,) in rows]


def test_an_order_goes_into_the_log_with_the_next_observation_and_is_reported(line, control, drive):
    for batch in drive.wires[:3]:
        line.send(batch)
    issued = order(line, "hold")
    assert issued["state"] == "issued"
    assert states(line) == [("hold", "issued")]
    line.send(drive.wires[3])
    eventually(line, [("hold", "done")])
    log = stored(line, control)
    with_orders = [o.seq for o in log if o.orders]
    assert with_orders == [drive.batches[3][-1].seq]
    assert log[with_orders[0]].orders[0].by == "operator"
    reply = line.send(drive.wires[4])
    assert reply["command"]["linear_mps"] == reply["command"]["angular_radps"] == 0.0
    state = line.get("/robots/r1")["state"]
    assert (state["activity"], state["reason"]) == ("holding", "standing still, ordered by operator")
    order(line, "resume")
    line.send(drive.wires[5])
    eventually(line, [("resume", "done"), ("hold", "done")])
    assert line.get("/robots/r1")["state"]["activity"] != "holding"
    assert [e["text"] for e in line.events("order")] == [
        "operator orders r1 to stand still.",
        "operator orders r1 to explore on.",
    ]


def test_a_replay_of_the_log_decides_the_same(line, control, drive):
    start = line.words["start_pose"]
    for k, batch in enumerate(drive.wires[:12]):
        if k == 4:
            order(line, "go_to", x_m=start["x_m"] + 1.0, y_m=start["y_m"])
        if k == 8:
            words = {"explore": "nearest", "coordinate": "hungarian", "communication": "none"}
            line.call("PATCH", "/robots/r1", words)
        reply = line.send(batch)
    agent = RobotAgent("r1", override(AgentConfig(), line.words["config"]))
    for observation in stored(line, control):
        update = agent.step(observation)
    assert reply["command"]["linear_mps"] == update.command.linear_mps
    assert reply["command"]["angular_radps"] == update.command.angular_radps
    assert line.get("/robots/r1")["state"]["methods"] == words
    assert update.methods == Methods(**words)


def test_a_place_in_the_world_is_told_in_the_robots_map(line, control, drive):
    for batch in drive.wires[:3]:
        line.send(batch)
    order(
        line,
        "explore_here",
        x_m=line.words["start_pose"]["x_m"] + 2.0,
        y_m=line.words["start_pose"]["y_m"] + 1.0,
    )
    line.send(drive.wires[3])
    (told,) = stored(line, control)[-1].orders
    agent = RobotAgent("r1", override(AgentConfig(), line.words["config"]))
    for observation in stored(line, control):
        heading = agent.step(observation).pose.theta  # in its map, which is north up
    turned = heading - line.get("/robots/r1")["state"]["yaw_rad"]
    expected = (2.0 * cos(turned) - sin(turned), 2.0 * sin(turned) + cos(turned))
    assert told.place_m == pytest.approx(expected, abs=0.1)


def test_sending_again_is_no_offence_though_an_order_was_added(line, drive):
    line.send(drive.wires[0])
    order(line, "hold")
    line.send(drive.wires[1])
    line.send(drive.wires[1])
    assert line.events("name_shared") == []


def test_an_agent_on_board_is_told_in_the_reply_and_puts_it_into_its_next_observation(control, drive):
    line = control.open()
    line.register("r1", agent="onboard", **line.words)
    line.send(drive.wires[0])
    order(line, "hold")
    reply = line.send(drive.wires[1])
    (told,) = reply["orders"]
    assert (told["kind"], told["by"]) == ("hold", "operator")
    assert states(line) == [("hold", "issued")]
    batch = [*drive.wires[2][:-1], {**drive.wires[2][-1], "orders": [told]}]
    assert observation_from_wire(batch[-1]).orders == (order_from_wire(told),)
    assert line.send(batch)["orders"] == []
    eventually(line, [("hold", "done")])


def test_methods_change_by_patch_and_unknown_ones_are_refused_with_the_known(line, drive):
    line.send(drive.wires[0])
    assert line.get("/robots/r1")["state"]["methods"]["explore"] == "waymark"
    response = line.call("PATCH", "/robots/r1", {"explore": "nearest"})
    assert response.json()["state"] == "issued"
    line.send(drive.wires[1])
    eventually(line, [("methods", "done")])
    assert line.get("/robots/r1")["state"]["methods"]["explore"] == "nearest"
    assert (
        line.events("order_done")[-1]["text"]
        == "r1, ordered to take explore nearest: done, explore by nearest."
    )
    refused = line.call("PATCH", "/robots/r1", {"explore": "astrology"})
    assert refused.status_code == 422
    error = refused.json()["error"]
    assert (error["code"], error["field"]) == ("unknown_method", "explore")
    assert "'astrology'; known are " in error["message"]
    assert "nearest" in error["message"]
    known = httpx.get(f"http://127.0.0.1:{line.control.port}/api/v1/methods").json()
    assert {"nearest", "waymark"} <= set(known["explore"])
    assert line.refused("PATCH", "/robots/r1", {}) == (422, "invalid", None)


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ({"kind": "go_to"}, "invalid"),
        ({"kind": "hold", "x_m": 1.0, "y_m": 2.0}, "invalid"),
        ({"kind": "methods"}, "invalid"),
        ({"kind": "dance"}, "invalid"),
        ({"kind": "go_to", "x_m": 1e9, "y_m": 0.0}, "invalid"),
    ],
)
def test_what_is_no_order_is_refused(line, body, code):
    assert line.refused("POST", "/robots/r1/orders", body)[:2] == (422, code)
    assert states(line) == []


def test_an_unknown_robot_and_too_many_orders_are_refused(line):
    assert line.refused("POST", "/robots/r9/orders", {"kind": "hold"})[:2] == (
        404,
        "unknown_robot",
    )
    for _ in range(16):
        order(line, "hold")
    assert line.refused("POST", "/robots/r1/orders", {"kind": "hold"})[:2] == (
        409,
        "too_many_orders",
    )


def test_orders_survive_a_restart_of_the_server(make_control, tmp_path, drive):
    control = make_control(tmp_path)
    line = control.open("m1")
    line.register("r1", **line.words)
    for batch in drive.wires[:2]:
        line.send(batch)
    order(line, "hold")
    line.send(drive.wires[2])
    eventually(line, [("hold", "done")])
    order(line, "resume")
    control.stop()
    again = make_control(tmp_path)
    line = again.line("m1")
    assert states(line) == [("resume", "issued"), ("hold", "done")]
    line.send(drive.wires[3])
    eventually(line, [("resume", "done"), ("hold", "done")])


def test_the_edges_of_the_unknown_are_told_by_rest_and_in_the_stream(line, drive):
    assert line.get("/robots/r1/frontiers") == {"robot_id": "r1", "frontiers": []}
    with line.stream() as stream:
        for batch in drive.wires[:15]:
            line.send(batch)
        state = stream.until(lambda s: s.state.get("frontiers/r1", {}).get("frontiers"))
    edges = line.get("/robots/r1/frontiers")["frontiers"]
    assert sum(edge["chosen"] for edge in edges) == 1
    assert edges[0]["chosen"]
    assert all(edge["length_m"] >= 0.5 for edge in edges)
    assert len(edges) <= 48
    assert {key for key in state if key.startswith(("frontiers/", "orders/"))} == {"frontiers/r1"}
