"""How what nodes measure goes: the slope of the last minutes, also after the server began again."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest

from db.records import MissionRecord, NodeRecord
from db.store import Store
from robots.types import NodeSensors, Observation, TagSighting
from server.board import Board
from server.history.recorder import Recorder
from server.mission.alerts import Alerts
from server.mission.events import Events
from server.mission.nodes import Nodes
from server.mission.trends import Trends
from server.sharing import node_value


def test_a_trend_is_the_slope_of_the_last_five_minutes() -> None:
    trends = Trends()
    for k in range(200):
        warm = 20.0 if k < 50 else 20.0 + 3.0 * (k - 50) / 15.0  # four seconds apart: 3 degrees a minute
        trends.add(4.0 * k, warm, None)
        if k == 5:
            assert trends.value()["temperature_c_per_min"] is None
    assert trends.value() == {"temperature_c_per_min": 3.0, "pressure_hpa_per_min": None}


def test_trends_are_back_after_a_restart(tmp_path: Path) -> None:
    began_s = time.time() - 180.0

    def reading(tag_id: str, k: int) -> NodeRecord:
        return NodeRecord(tag_id, 20.0 + 0.6 * k, None, None, None, began_s + 6.0 * k, "r1")

    async def scenario() -> None:
        store = await Store.open(tmp_path / "m.db")
        await store.missions.create_mission(MissionRecord("m", "M", "running", 0.0))
        before, now = Board(), [0.0]
        recorder = Recorder(store, "m", before, lambda: None, lambda: now[0])
        trends = {"N1": Trends(), "N2": Trends()}
        for k in range(30):  # N1 gets warmer for three minutes, N2 is heard for the first of them alone
            for name in trends if k < 11 else ("N1",):
                node = reading(name, k)
                trends[name].add(node.heard_unix_s, node.temperature_c, None)
                before.publish({f"node/{name}": node_value(node, trends[name].value())})
            now[0] = began_s + 6.0 * k
            await recorder.flush()
        await store.nodes.record_readings("m", [reading("N1", 29), reading("N2", 10)])

        after = Board()
        nodes = Nodes(store, "m", after, Alerts(store, "m", after, Events(store, "m", after)))
        await nodes.restore()
        for name in trends:
            node = after.get(f"node/{name}")
            assert node == before.get(f"node/{name}")
            assert node is not None
            assert node["temperature_c_per_min"] == pytest.approx(6.0, abs=0.01)
        # the next reading goes on from those before the restart
        sighting = TagSighting("N1", -50.0, sensors=NodeSensors(38.0, None, None))
        await nodes.take("r1", [Observation(seq=0, stamp_s=0.0, tag_sightings=(sighting,))])
        node = after.get("node/N1")
        assert node is not None
        assert node["temperature_c_per_min"] == pytest.approx(6.0, abs=0.05)
        await store.close()

    asyncio.run(scenario())
