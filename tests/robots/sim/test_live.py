import json
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from robots.client import ClientError
from robots.config import AgentConfig
from robots.overrides import override
from robots.sim import wire
from robots.sim.live import LiveError, changes, main, play
from robots.sim.runner import run
from robots.sim.scenario import RadioCut, ScenarioConfig

SMALL = ScenarioConfig(map="open:80", robots=3, minutes=0.4, victims=1, seed=2, noise_level=1)


@pytest.fixture
def control(fake_control, wanderer, merge):
    """A fake mission control whose agents are wanderers."""
    agents = {}

    def decide(robot_id, observations):
        agent = agents.setdefault(robot_id, wanderer(robot_id, AgentConfig()))
        updates = [agent.step(wire.observation_from_wire(item)) for item in observations]
        return wire.command_to_wire(merge(updates))

    fake_control.decide = decide
    return fake_control


def tracks(config, control, **options):
    """Play live and return the true poses, (periods, n, 3)."""
    seen = []
    result = play(config, control.url, "m", speed=0.0, progress=lambda s: seen.append(s.track[-1]), **options)
    return result, np.array(seen)


def direct(config, wanderer, merge):
    seen = []
    run(config, wanderer, merge=merge, progress=lambda s: seen.append(s.track[-1]))
    return np.array(seen)


def test_live_and_direct_give_the_same_result(control, wanderer, merge):
    result, live = tracks(SMALL, control)
    assert not result.stopped
    assert result.clock_s == pytest.approx(24.0)
    assert np.array_equal(live, direct(SMALL, wanderer, merge))
    assert result.score.distance_m > 5.0
    assert control.connections <= 6  # one line per robot, and those that were opened first


def test_so_they_do_when_the_radio_is_cut(control, wanderer, merge):
    config = replace(SMALL, radio_cuts=(RadioCut("r2", 3.0, 15.0),))
    _, live = tracks(config, control)
    assert np.array_equal(live, direct(config, wanderer, merge))
    assert max(len(post["observations"]) for post in control.posts["r2"]) > 200
    assert max(len(post["observations"]) for post in control.posts["r1"]) == 4


def test_an_agent_on_board_decides_alone_and_tells_later(control, wanderer, merge):
    config = replace(SMALL, agent="onboard", radio_cuts=(RadioCut("r2", 3.0, 15.0),))
    _, live = tracks(config, control, agent_factory=wanderer, merge=merge)
    assert np.array_equal(live, direct(config, wanderer, merge))
    assert control.robots["r2"]["agent"] == "onboard"
    posts = control.posts["r2"]
    backlog = max(posts, key=lambda post: len(post["observations"]))
    assert [item["seq"] for item in backlog["onboard"]] == [item["seq"] for item in backlog["observations"]]
    assert set(backlog["onboard"][0]) == {"seq", "pose", "command"}
    assert sum(len(post["observations"]) for post in posts) == 480


def test_robots_register_with_what_the_scenario_says(control):
    config = replace(
        SMALL,
        minutes=0.05,
        poses="truth",
        agent_config=override(AgentConfig(), {"body": {"max_speed_mps": 0.3}}),
    )
    play(config, control.url, "m", speed=0.0, name="Drill")
    assert control.missions["m"]["name"] == "Drill"
    body = control.robots["r2"]
    assert body["config"] == {"body": {"max_speed_mps": 0.3}, "poses": "truth", "seed": 2}
    assert override(AgentConfig(), body["config"]) == config.agent_of("r1")
    assert body["silence"] == {"after_s": 2.0, "policy": "hold"}
    assert set(body["start_pose"]) == {"x_m", "y_m", "yaw_rad", "sd_m", "sd_rad"}


def test_stop_holds_the_robot_until_it_is_taken_back(control):
    positions = {}

    def progress(simulation):
        positions[round(simulation.clock_s, 1)] = simulation.truth("r1")
        if round(simulation.clock_s, 1) == 5.0:
            control.stopped.add("r1")
        if round(simulation.clock_s, 1) == 10.0:
            control.stopped.discard("r1")

    play(SMALL, control.url, "m", speed=0.0, progress=progress)
    assert positions[7.0] == positions[10.0]
    assert positions[14.0] != positions[10.0]
    held = [item["stamp_s"] for item in control.observations["r1"] if item.get("held")]
    assert held[0] == pytest.approx(5.25)
    assert held[-1] == pytest.approx(10.2)


def test_a_server_that_restarts_changes_nothing(control, wanderer, merge):
    def progress(simulation):
        if round(simulation.clock_s, 1) == 4.0:
            control.stop()
            threading.Timer(0.3, control.start).start()
        seen.append(simulation.track[-1])

    seen: list[np.ndarray] = []
    result = play(SMALL, control.url, "m", speed=0.0, progress=progress)
    assert not result.stopped
    assert np.array_equal(np.array(seen), direct(SMALL, wanderer, merge))


def test_lost_replies_change_nothing(control, wanderer, merge):
    def progress(simulation):
        control.failures = ["late", "drop"]
        seen.append(simulation.track[-1])

    seen: list[np.ndarray] = []
    config = replace(SMALL, minutes=0.1)
    play(config, control.url, "m", speed=0.0, progress=progress)
    control.failures = []
    assert np.array_equal(np.array(seen), direct(config, wanderer, merge))


def test_speed_is_a_factor_of_real_time(control):
    began = time.monotonic()
    play(replace(SMALL, minutes=0.05), control.url, "m", speed=6.0)
    assert time.monotonic() - began > 0.45  # 3 s of mission at six times the speed


def test_a_mission_with_these_robots_is_refused(control):
    config = replace(SMALL, minutes=0.02)
    play(config, control.url, "m", speed=0.0)
    with pytest.raises(LiveError, match="r1 has observations in this mission already"):
        play(config, control.url, "m", speed=0.0)
    with pytest.raises(ClientError, match="other words"):
        play(replace(config, seed=9), control.url, "m", speed=0.0)


def test_stop_ends_a_mission_that_waits_for_its_server(control):
    stop = threading.Event()

    def progress(simulation):
        if round(simulation.clock_s, 1) == 2.0:
            control.blocked.clear()
            threading.Timer(0.2, stop.set).start()

    result = play(SMALL, control.url, "m", speed=0.0, stop=stop, progress=progress)
    assert result.stopped


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_the_command_cleanly(control, number):
    control.decide = lambda *_: dict(wire.command_to_wire(wire.Command(0.1)))
    words = [
        sys.executable,
        "-m",
        "robots.sim.live",
        "--url",
        control.url,
        "--mission",
        "m",
        "--map",
        "open:40",
    ]
    process = subprocess.Popen(
        [*words, "--robots", "2", "--victims", "0", "--speed", "5"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    while len(control.posts.get("r2", [])) < 3:
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert err == b""
    assert b"m driven" in out


def test_the_command_says_what_is_wrong(control, capsys):
    assert main(["--url", control.url, "--mission", "m", "--map", "nowhere.yaml"]) == 1
    assert "nowhere.yaml" in capsys.readouterr().err
    assert main(["--url", "nonsense", "--mission", "m", "--map", "open:40"]) == 1
    assert "not the address" in capsys.readouterr().err
    assert main(["--url", control.url, "--mission", "m", "--robots", "0"]) == 1
    assert capsys.readouterr().err == "error: robots 0 is out of range; give 1 to 100\n"


def test_changes_are_what_override_takes():
    config = override(AgentConfig(), {"mapping": {"resolution_m": 0.1}, "poses": "truth"})
    assert json.loads(json.dumps(changes(config, AgentConfig()))) == {
        "mapping": {"resolution_m": 0.1},
        "poses": "truth",
    }
    assert changes(AgentConfig(), AgentConfig()) == {}
