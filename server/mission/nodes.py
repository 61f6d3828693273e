"""Active nodes: what they measure of their places, and the alerts about it."""

from __future__ import annotations

import asyncio
import time
from collections import defaultdict
from collections.abc import Iterable

import structlog

from db.errors import DatabaseError
from db.records import NodeRecord
from db.store import Store
from robots.types import NodeSensors, Observation
from server.board import Board
from server.history.changes import Value
from server.history.past import Past, steps
from server.mission.alerts import Alerts
from server.mission.node_alerts import RULES, Watch, with_usual_pressure
from server.mission.trends import TREND_S, Trends
from server.sharing import node_value

_SAVE_S = 5.0  # readings are saved so often

log = structlog.get_logger()


class Nodes:
    """Latest readings by tag id."""

    def __init__(self, store: Store, mission_id: str, board: Board, alerts: Alerts) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._alerts = alerts
        self._nodes: dict[str, NodeRecord] = {}
        self._watches: dict[str, tuple[Watch, ...]] = {}
        self._trends: defaultdict[str, Trends] = defaultdict(Trends)
        self._unsaved: set[str] = set()
        self._saved_s = 0.0
        self._changing = asyncio.Lock()

    async def restore(self) -> None:
        """Bring the readings back from the database; the alerts have to be there."""
        for node in await self._store.nodes.readings_of(self._mission_id):
            self._nodes[node.tag_id] = node
        for tag_id in self._nodes:
            for watch in self._watches_of(tag_id):
                watch.active = self._alerts.is_on(watch.rule.kind, tag_id)
        told = await self._recall()
        self._board.publish(
            {f"node/{tag_id}": node_value(node, told.get(tag_id, {})) for tag_id, node in self._nodes.items()}
        )

    async def _recall(self) -> dict[str, dict[str, float | None]]:
        """Bring the readings of the last minutes back from the past; return each node's last trends."""
        past = Past(self._store, self._mission_id)
        spans = await past.spans()
        told: dict[str, dict[str, float | None]] = {}
        for span in spans:
            if span.ends_unix_s < spans[-1].ends_unix_s - TREND_S:
                continue
            chunk = await past.chunk(span.number)
            for node in [] if chunk is None else await asyncio.to_thread(_readings_in, chunk[0]):
                tag_id = node["tag_id"]
                self._trends[tag_id].add(node["heard_unix_s"], node["temperature_c"], node["pressure_hpa"])
                told[tag_id] = {name: node.get(name) for name in Trends().value()}
        return told

    async def take(self, robot_id: str, observations: Iterable[Observation]) -> None:
        """Take over what nodes measured, in the order in which a robot heard it."""
        heard = [
            (s.tag_id, s.sensors) for o in observations for s in o.tag_sightings if s.sensors is not None
        ]
        if not heard:
            return
        async with self._changing:
            for tag_id, sensors in heard:
                await self._measured(robot_id, tag_id, sensors)
            tags = sorted({tag_id for tag_id, _ in heard})
            self._board.publish(
                {
                    f"node/{tag_id}": node_value(self._nodes[tag_id], self._trends[tag_id].value())
                    for tag_id in tags
                }
            )
            self._unsaved.update(tags)
            if time.monotonic() - self._saved_s >= _SAVE_S:
                await self.save()

    async def save(self) -> None:
        """Save the readings that are not saved yet."""
        self._saved_s = time.monotonic()
        records = [self._nodes[tag_id] for tag_id in sorted(self._unsaved)]
        if not records:
            return
        try:
            await self._store.nodes.record_readings(self._mission_id, records)
            self._unsaved.difference_update(record.tag_id for record in records)
        except DatabaseError as error:  # the log has them
            log.error("readings of nodes could not be saved", reason=str(error))

    async def _measured(self, robot_id: str, tag_id: str, sensors: NodeSensors) -> None:
        known = self._nodes.get(tag_id)
        node = NodeRecord(
            tag_id,
            _newer(sensors.temperature_c, None if known is None else known.temperature_c),
            _newer(sensors.pressure_hpa, None if known is None else known.pressure_hpa),
            _newer(sensors.tilt_rad, None if known is None else known.tilt_rad),
            None,
            time.time(),
            robot_id,
        )
        node = with_usual_pressure(node, None if known is None else known.usual_pressure_hpa)
        self._nodes[tag_id] = node
        self._trends[tag_id].add(node.heard_unix_s, node.temperature_c, node.pressure_hpa)
        for watch in self._watches_of(tag_id):
            if watch.take(node):
                await self._tell(watch, node)

    async def _tell(self, watch: Watch, node: NodeRecord) -> None:
        """Raise or end an alert."""
        rule, tag_id = watch.rule, node.tag_id
        if watch.active:
            text = rule.raised(node)
            await self._alerts.raise_(
                rule.kind,
                tag_id,
                text,
                rule.severity,
                event=f"node_{rule.kind}",
                robot_id=node.robot_id,
                tag_id=tag_id,
            )
        else:
            await self._alerts.end(rule.kind, tag_id, rule.over(node), event=f"node_{rule.kind}_over")

    def _watches_of(self, tag_id: str) -> tuple[Watch, ...]:
        if tag_id not in self._watches:
            self._watches[tag_id] = tuple(Watch(rule) for rule in RULES)
        return self._watches[tag_id]


def _newer(value: float | None, known: float | None) -> float | None:
    return known if value is None else value


def _readings_in(chunk: bytes) -> list[Value]:
    """Return what a chunk of the past tells of nodes, in order."""
    found: list[Value] = []
    last: dict[str, Value] = {}
    for _, state in steps(chunk):
        for key, value in state.items():
            if key.startswith("node/") and last.get(key) is not value:
                last[key] = value
                found.append(value)
    return found
