"""Alerts: raised once, over when what they are about is over, kept until somebody has taken note."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace
from typing import Any

import structlog

from db.errors import DatabaseError
from db.records import AlertKind, AlertRecord, Severity
from db.store import Store
from server.board import Board
from server.errors import unknown
from server.mission.events import Events
from server.sharing import alert_value

log = structlog.get_logger()


class Alerts:
    """Alerts by id (``kind:subject``) until they are over and acknowledged."""

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store.alerts
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._alerts: dict[str, AlertRecord] = {}
        self._changing = asyncio.Lock()  # an acknowledgement must not be lost to what comes meanwhile

    async def restore(self) -> None:
        """Bring the alerts back from the database."""
        for alert in await self._store.alerts_of(self._mission_id):
            if not alert.settled:
                self._keep(alert)

    def all(self) -> list[AlertRecord]:
        """Return the alerts that are not settled, the earliest first."""
        return sorted(self._alerts.values(), key=lambda alert: (alert.raised_unix_s, alert.alert_id))

    def get(self, kind: AlertKind, subject: str) -> AlertRecord | None:
        """Return such an alert, if there is one that is not settled."""
        return self._alerts.get(f"{kind}:{subject}")

    def is_on(self, kind: AlertKind, subject: str) -> bool:
        """Say whether such an alert goes on."""
        alert = self.get(kind, subject)
        return alert is not None and alert.over_unix_s is None

    async def raise_(
        self,
        kind: AlertKind,
        subject: str,
        text: str,
        severity: Severity,
        *,
        event: str,
        robot_id: str | None = None,
        tag_id: str | None = None,
        victim_id: str | None = None,
        is_anew: bool = False,
    ) -> AlertRecord:
        """Raise an alert, unless it goes on already as severe as that, and tell of it as an event.

        ``is_anew``: it is raised even so.

        One that was acknowledged has to be again when it gets worse or comes back.
        """
        async with self._changing:
            known = self.get(kind, subject)
            goes_on = known is not None and known.over_unix_s is None and known.severity == severity
            if known is not None and goes_on and not is_anew:
                return known
            record = AlertRecord(
                f"{kind}:{subject}", kind, text, severity, time.time(), robot_id, tag_id, victim_id
            )
            await self._save(record)
        await self._events.tell(event, text, robot_id, severity)
        return record

    async def settle(self, kind: AlertKind, subject: str, by: str) -> None:
        """End an alert that somebody has dealt with, which takes note of it too; tell nothing more."""
        async with self._changing:
            alert = self._alerts.get(f"{kind}:{subject}")
            if alert is None:
                return
            now = time.time()
            alert = replace(alert, over_unix_s=now if alert.over_unix_s is None else alert.over_unix_s)
            if alert.acknowledged_unix_s is None:
                alert = replace(alert, acknowledged_by=by, acknowledged_unix_s=now)
            await self._save(alert)

    async def end(self, kind: AlertKind, subject: str, text: str, *, event: str) -> None:
        """End an alert, if there is one that goes on, and tell of it as an event."""
        async with self._changing:
            if not self.is_on(kind, subject):
                return
            alert = replace(self._alerts[f"{kind}:{subject}"], over_unix_s=time.time())
            await self._save(alert)
        await self._events.tell(event, text, alert.robot_id)

    async def acknowledge(self, alert_id: str, by: str) -> AlertRecord:
        """Keep that somebody has taken note of an alert; the first one counts.

        Raises:
            ApiError: there is no such alert, or it is settled already.
            DatabaseError: it could not be kept.
        """
        async with self._changing:
            if alert_id not in self._alerts:
                raise unknown("alert", alert_id)
            alert = self._alerts[alert_id]
            if alert.acknowledged_unix_s is not None:
                return alert
            alert = replace(alert, acknowledged_by=by, acknowledged_unix_s=time.time())
            await self._store.record_alert(self._mission_id, alert)
            self._keep(alert)
        after_s = (alert.acknowledged_unix_s or 0.0) - alert.raised_unix_s
        text = f"{by} has taken note after {after_s:.0f} s: {alert.text}"
        await self._events.tell("alert_acknowledged", text, alert.robot_id)
        return alert

    async def _save(self, alert: AlertRecord) -> None:
        try:
            await self._store.record_alert(self._mission_id, alert)
        except DatabaseError as error:  # people have to see it all the same
            log.error("an alert could not be saved", alert_id=alert.alert_id, reason=str(error))
        self._keep(alert)

    def _keep(self, alert: AlertRecord) -> None:
        key = f"alert/{alert.alert_id}"
        values: dict[str, dict[str, Any] | None] = {key: alert_value(alert)}
        if not alert.settled:
            self._alerts[alert.alert_id] = alert
        else:
            self._alerts.pop(alert.alert_id, None)
            values = {key: None} if self._board.get(key) is not None else {}
        self._board.publish(values)
