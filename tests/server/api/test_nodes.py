"""What nodes measure, from the robot to those who watch: readings, alerts, and who took note."""

from itertools import cycle

import pytest

from robots.client import RobotClient
from robots.config import AgentConfig
from robots.sim.hostile import HostileConfig
from robots.sim.live import play
from robots.sim.scenario import SLAM_KINDS, ScenarioConfig

CALM = {"temperature_c": 21.0, "pressure_hpa": 1012.5, "tilt_rad": 0.02}


def hear(line, seq, tag_id="N7", **sensors):
    sighting = {"tag_id": tag_id, "rssi_dbm": -40.0, "sensors": sensors}
    line.send([{"seq": seq, "stamp_s": 1.0 * seq, "tag_sightings": [sighting]}])


def test_readings_of_a_node_are_shown_before_its_place_is_known(line):
    assert line.refused("GET", "/tags/N7/sensors") == (404, "unknown_node", None)
    hear(line, 0, **CALM)
    hear(line, 1, temperature_c=23.0)  # what a sighting leaves out stays
    found = line.get("/tags/N7/sensors")
    assert {name: found[name] for name in CALM} == CALM | {"temperature_c": 23.0}
    assert (found["tag_id"], found["robot_id"]) == ("N7", "r1")
    with line.stream() as stream:
        assert stream.state["node/N7"] == found
    assert line.get("/alerts") == {"alerts": []}


def test_an_alert_is_raised_acknowledged_and_over(line):
    with line.stream() as stream:
        for seq in range(3):
            hear(line, seq, **CALM | {"temperature_c": 80.0 + seq})
        stream.until(lambda s: "alert/hot:N7" in s.state)
        (alert,) = line.get("/alerts")["alerts"]
        assert (alert["kind"], alert["severity"], alert["tag_id"]) == ("hot", "alarm", "N7")
        assert alert["text"] == "It is hot at node N7: 81 °C."
        (event,) = line.events("node_hot")
        assert (event["severity"], event["text"]) == ("alarm", alert["text"])
        at = "/alerts/hot:N7/acknowledge"
        noted = line.call("POST", at).json()
        assert (noted["acknowledged_by"], noted["over_unix_s"]) == ("operator", None)
        assert line.call("POST", at).json() == noted  # the first one counts
        stream.until(lambda s: s.state["alert/hot:N7"]["acknowledged_by"] == "operator")
        for seq in range(3, 14):
            hear(line, seq, **CALM)
        stream.until(lambda s: "alert/hot:N7" not in s.state)
    assert line.get("/alerts") == {"alerts": []}
    assert len(line.events("node_hot_over")) == 1
    assert line.refused("POST", at) == (404, "unknown_alert", None)


def test_an_alert_that_is_over_stays_until_somebody_takes_note(line):
    for seq in range(14):
        hear(line, seq, **CALM | ({"tilt_rad": 1.4} if seq < 3 else {}))
    (alert,) = line.get("/alerts")["alerts"]
    assert alert["kind"] == "tilted"
    assert alert["over_unix_s"] >= alert["raised_unix_s"]
    line.call("POST", f"/alerts/{alert['alert_id']}/acknowledge")
    assert line.get("/alerts") == {"alerts": []}


def test_readings_and_alerts_outlive_a_restart(tmp_path, make_control):
    line = make_control(tmp_path).open("mine")
    line.register(**line.words)
    for seq in range(3):
        hear(line, seq, **CALM | {"pressure_hpa": 1012.5 - 5.0 * (seq > 0)})
    before = line.get("/alerts"), line.get("/tags/N7/sensors")
    assert [alert["kind"] for alert in before[0]["alerts"]] == ["pressure"]
    line.control.stop()
    line.control.start()
    assert (line.get("/alerts"), line.get("/tags/N7/sensors")) == before
    hear(line, 3, **CALM | {"pressure_hpa": 1007.5})  # goes on: no news
    assert len(line.events("node_pressure")) == 1


def test_readings_that_cannot_be_saved_are_shown_all_the_same(line):
    with line.control.failing("node_readings", "alerts"):
        for seq in range(3):
            hear(line, seq, **CALM | {"temperature_c": 90.0})
    assert line.get("/tags/N7/sensors")["temperature_c"] == 90.0
    assert [alert["kind"] for alert in line.get("/alerts")["alerts"]] == ["hot"]


@pytest.mark.parametrize("value", [1e9, -300.0, "warm"])
def test_a_reading_that_is_none_is_refused(line, value):
    sighting = {"tag_id": "N7", "rssi_dbm": -40.0, "sensors": {"temperature_c": value}}
    status, code, field = line.refused_post([{"seq": 0, "stamp_s": 0.0, "tag_sightings": [sighting]}])
    assert (status, code) == (422, "invalid")
    assert field == "observations.0.tag_sightings.0.sensors.temperature_c"


def test_a_mixed_team_among_nodes_finds_the_fire(control):
    """Robots of every kind of SLAM in one mission: each is told its own, nodes are heard, one is hot."""
    kinds = [kind for kind, _ in zip(cycle(SLAM_KINDS), range(max(3, len(SLAM_KINDS))), strict=False)]
    scenario = ScenarioConfig(
        map="office:100",
        robots=len(kinds),
        minutes=0.4,
        seed=3,
        victims=0,
        tags="node",
        environment="office2",
        tags_in_place=12,
        slam=tuple((f"r{number}", kind) for number, kind in enumerate(kinds, 1)),
        hostile=HostileConfig(fires=2, spikes=20, dead_tags=1),
        agent_config=AgentConfig(map_memory=True),
    )
    url = f"http://127.0.0.1:{control.port}"
    result = play(scenario, url, "mixed", speed=0.0, client_type=RobotClient)
    assert result.clock_s == pytest.approx(24.0)
    mission = control.missions.get("mixed")
    robots = control.call("GET", "/missions/mixed/robots").json()["robots"]
    assert [robot["slam"] for robot in robots] == kinds
    assert [robot["state"]["slam"] for robot in robots] == kinds
    nodes = mission.board.of_kind("node")
    assert len(nodes) >= 10
    assert "hot" in {alert.kind for alert in mission.alerts.all()}
    tags = control.call("GET", "/missions/mixed/tags").json()["tags"]
    sensed = [tag["sensors"]["temperature_c"] for tag in tags if tag["sensors"] is not None]
    assert sensed, "no tag on the map tells what it measures"
    assert max(node["temperature_c"] for node in nodes) > 60.0
