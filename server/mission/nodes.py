"""Active nodes: what they measure of their places, and the alerts about it."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable
from dataclasses import replace

import structlog

from db.errors import DatabaseError
from db.records import AlertRecord, NodeRecord
from db.store import Store
from robots.types import NodeSensors, Observation
from server.board import Board
from server.errors import unknown
from server.mission.events import Events
from server.mission.node_alerts import RULES, Watch, with_usual_pressure
from server.sharing import alert_value, node_value

_SAVE_S = 5.0  # readings are saved so often; alerts at once

log = structlog.get_logger()


class Nodes:
    """Latest readings by tag id, and alerts by id (``kind:tag``) until they are over and acknowledged."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._nodes: dict[str, NodeRecord] = {}
        self._watches: dict[str, tuple[Watch, ...]] = {}
        self._alerts: dict[str, AlertRecord] = {}
        self._unsaved: set[str] = set()
        self._saved_s = 0.0
        self._changing = (
            asyncio.Lock()
        )  # an acknowledgement must not be lost to a reading that comes meanwhile

    async def restore(self) -> None:
        """Bring readings and alerts back from the database."""
        for node in await self._store.nodes.readings_of(self._mission_id):
            self._nodes[node.tag_id] = node
        for alert in await self._store.nodes.alerts_of(self._mission_id):
            if alert.over_unix_s is None:
                for watch in self._watches_of(alert.tag_id):
                    watch.active |= watch.rule.kind == alert.kind
            if not alert.settled:
                self._alerts[alert.alert_id] = alert
        self._board.publish({f"node/{node.tag_id}": node_value(node) for node in self._nodes.values()})
        self._board.publish({f"alert/{a.alert_id}": alert_value(a) for a in self._alerts.values()})

    def alerts(self) -> list[AlertRecord]:
        """Return the alerts that are not settled, the earliest first."""
        return sorted(self._alerts.values(), key=lambda alert: (alert.raised_unix_s, alert.alert_id))

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
            self._board.publish({f"node/{tag_id}": node_value(self._nodes[tag_id]) for tag_id in tags})
            self._unsaved.update(tags)
            if time.monotonic() - self._saved_s >= _SAVE_S:
                await self.save()

    async def acknowledge(self, alert_id: str, by: str) -> AlertRecord:
        """Keep that somebody has taken note of an alert; the first one counts.

        Raises:
            ApiError: there is no such alert, or it is settled already.
        """
        async with self._changing:
            if alert_id not in self._alerts:
                raise unknown("alert", alert_id)
            alert = self._alerts[alert_id]
            if alert.acknowledged_unix_s is not None:
                return alert
            alert = replace(alert, acknowledged_by=by, acknowledged_unix_s=time.time())
            await self._store.nodes.record_alert(self._mission_id, alert)
            self._keep(alert)
        await self._events.tell("alert_acknowledged", f"{by} has taken note: {alert.text}", alert.robot_id)
        return alert

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
        for watch in self._watches_of(tag_id):
            if watch.take(node):
                await self._tell(watch, node)

    async def _tell(self, watch: Watch, node: NodeRecord) -> None:
        """Raise or end an alert."""
        rule = watch.rule
        alert_id = f"{rule.kind}:{node.tag_id}"
        text = rule.raised(node) if watch.active else rule.over(node)
        if watch.active:
            alert = AlertRecord(
                alert_id, node.tag_id, rule.kind, text, node.robot_id, rule.severity, node.heard_unix_s
            )
        elif alert_id in self._alerts:
            alert = replace(self._alerts[alert_id], over_unix_s=node.heard_unix_s)
        else:
            return
        try:
            await self._store.nodes.record_alert(self._mission_id, alert)
        except DatabaseError as error:  # people have to see it all the same
            log.error("an alert could not be saved", alert_id=alert_id, reason=str(error))
        self._keep(alert)
        severity = rule.severity if watch.active else "info"
        kind = f"node_{rule.kind}" if watch.active else f"node_{rule.kind}_over"
        await self._events.tell(kind, text, node.robot_id, severity)

    def _keep(self, alert: AlertRecord) -> None:
        key = f"alert/{alert.alert_id}"
        if alert.settled:
            self._alerts.pop(alert.alert_id, None)
            self._board.publish({key: None} if self._board.get(key) is not None else {})
        else:
            self._alerts[alert.alert_id] = alert
            self._board.publish({key: alert_value(alert)})

    def _watches_of(self, tag_id: str) -> tuple[Watch, ...]:
        if tag_id not in self._watches:
            self._watches[tag_id] = tuple(Watch(rule) for rule in RULES)
        return self._watches[tag_id]


def _newer(value: float | None, known: float | None) -> float | None:
    return known if value is None else value
