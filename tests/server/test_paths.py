"""The same scenario stepped directly and played through the real server: the same mission, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robots.sim.live import play
from robots.sim.runner import run
from robots.sim.scenario import RadioCut, ScenarioConfig
from robots.sim.simulation import Simulation

SCENARIO = ScenarioConfig(map="office:120", robots=2, minutes=0.4, seed=11, victims=2)


@pytest.mark.parametrize(
    "scenario",
    [
        SCENARIO,
        replace(SCENARIO, agent="onboard", radio_cuts=(RadioCut("r1", 4.0, 16.0),)),
        replace(SCENARIO, radio_cuts=(RadioCut("r2", 4.0, 12.0),)),
    ],
    ids=["server", "onboard-through-silence", "server-through-silence"],
)
def test_direct_and_through_the_server_give_the_same_mission(control, scenario):
    tracks: list[np.ndarray] = []

    def note(simulation: Simulation) -> None:
        tracks.append(np.array(simulation.track[-1]))

    direct = run(scenario, progress=note)
    directly, tracks = tracks, []
    mission_id = f"paths-{scenario.agent}-{len(scenario.radio_cuts)}"
    live = play(scenario, f"http://127.0.0.1:{control.port}", mission_id, speed=0.0, progress=note)
    assert live.clock_s == direct.clock_s
    np.testing.assert_array_equal(np.array(tracks), np.array(directly))
    events = control.call("GET", f"/missions/{mission_id}/events").json()["events"]
    assert "onboard_differs" not in {event["kind"] for event in events}
