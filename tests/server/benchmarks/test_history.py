"""The benchmark of the past records a mission that can be read again."""

import asyncio

from server.benchmarks import history
from server.benchmarks.past_mission import PastMission


def test_a_short_mission_is_recorded_and_read(tmp_path):
    found = asyncio.run(history._record(tmp_path / "m.db", robots=2, minutes=0.2))
    assert 0.0 < found["chunks_mb"] < found["whole_mb"] < 1.0
    assert found["recording_share_of_a_core"] > 0.0
    assert found["state_at_median_ms"] > 0.0


def test_the_mission_it_makes_up_is_the_same_each_time_and_moves():
    first, second = (list(PastMission(2, seed=3).ticks(0.1)) for _ in range(2))
    assert first == second
    assert len(first) == 13
    assert len({values["robot/r1"]["x_m"] for _, values in first}) == 13
