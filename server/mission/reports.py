"""Reports from the field: each counts once, however often and in whatever order they arrive."""

from __future__ import annotations

import asyncio
import time
from typing import Any
from uuid import UUID

from db.records import AnnotationRecord
from db.reports import ReportRecord
from db.store import Store
from db.victim_records import SaidRecord, StartRecord, VictimRecord
from server.board import Board
from server.errors import ApiError
from server.mission.alerts import Alerts
from server.mission.annotations import Annotations
from server.mission.chip_notes import ChipNotes
from server.mission.evacuation import Evacuation
from server.mission.mayday import call_for_help
from server.mission.touches import too_far
from server.mission.victims import Victims
from server.mission.walks import Walks
from server.schemas.reports import ReportIn
from server.sharing import beside

_LATE_S = 60.0
_RESTORED = 20_000  # touches: twenty people for eight hours, two a minute
_CLOCKS = {"kind", "made_by", "is_carried", "phone_unix_s", "offset_s", "sent_phone_unix_s"}


class Reports:
    """Takes reports: what they say is done and kept, and done again where the server died between the two."""

    def __init__(
        self,
        store: Store,
        mission_id: str,
        board: Board,
        annotations: Annotations,
        victims: Victims,
        alerts: Alerts,
        evacuation: Evacuation,
        chip_notes: ChipNotes,
    ) -> None:
        self._store = store.reports
        self._mission_id = mission_id
        self._board = board
        self._annotations = annotations
        self._victims = victims
        self._alerts = alerts
        self._evacuation = evacuation
        self._chip_notes = chip_notes
        self._walks = Walks(board)
        self._taking = asyncio.Lock()  # one sent twice at the same time counts once too

    async def restore(self) -> None:
        """Show again where people were last and where they walked."""
        for record in reversed(await self._store.latest(self._mission_id, _RESTORED, "at")):
            self._show_place(record)
            self._walks.take(record.body)
        for record in await self._store.latest(self._mission_id, _RESTORED, "victim"):
            counts = record.body.get("live"), record.body.get("dead")
            self._chip_notes.knows_victim(
                record.body["tag_id"], record.by, *counts, record.body.get("text", "")
            )

    async def has(self, report_id: UUID) -> bool:
        """Say whether a report was taken."""
        return await self._store.get(self._mission_id, str(report_id)) is not None

    async def latest(self, limit: int) -> list[ReportRecord]:
        """Return the latest reports, the newest first."""
        return await self._store.latest(self._mission_id, limit)

    async def take(self, report_id: UUID, said: ReportIn, sender: str) -> tuple[ReportRecord, bool]:
        """Take a report from somebody who is logged in as ``sender``; say whether it is new.

        Raises:
            ApiError: it cannot be taken, and nothing of it is kept.
            DatabaseError: it could not be kept.
        """
        async with self._taking:
            known = await self._store.get(self._mission_id, str(report_id))
            if known is not None:
                return known, False
            now = time.time()
            record = ReportRecord(
                report_id=str(report_id),
                kind=said.kind,
                by=_signature(said, sender),
                made_unix_s=made_at(said, now),
                received_unix_s=now,
                phone_unix_s=said.phone_unix_s,
                offset_s=said.offset_s,
                body=said.model_dump(exclude=_CLOCKS, exclude_none=True),
                outcome="",
            )
            outcome = await getattr(self, f"_take_{said.kind}")(record, said)
            record = ReportRecord(**{**_values(record), "outcome": outcome})
            await self._store.record(self._mission_id, record)
            return record, True

    async def _take_note(self, record: ReportRecord, said: ReportIn) -> str:
        assert said.note is not None
        note = AnnotationRecord(
            annotation_id=record.report_id,
            kind=said.note,
            text=said.text,
            x_m=None,
            y_m=None,
            tag_id=said.tag_id,
            by=record.by,
            created_unix_s=record.made_unix_s,
            changed_unix_s=record.received_unix_s,
        )
        if self._chip_notes.is_copy(note):
            return "Its writer has reported it already."
        await self._annotations.put(note)
        await self._chip_notes.is_reported(note)
        return f"It stands on the map at tag {said.tag_id}."

    async def _take_victim(self, record: ReportRecord, said: ReportIn) -> str:
        assert said.tag_id is not None
        await self._chip_notes.victim_is_reported(said.tag_id, record.by, said.live, said.dead, said.text)
        tag = self._board.get(f"tag/{said.tag_id}")
        start = StartRecord() if said.start is None else StartRecord(**said.start.model_dump())
        if tag is None:  # where that is, is not known yet: the note moves there once it is
            counts = f"{said.live or 0} live, {said.dead or 0} dead, START: {start.triage}. {said.text}"
            note = said.model_copy(update={"note": "victim", "text": counts.strip()})
            return await self._take_note(record, note)
        victim_id = f"p-{record.report_id[:8]}"
        place = beside(tag["x_m"], tag["y_m"], tag["covariance"])
        words = SaidRecord(
            status="reached",
            note=f"At tag {said.tag_id}. {said.text}".strip(),
            live=said.live,
            dead=said.dead,
            start=start,
            tag_id=said.tag_id,
            by=record.by,
            changed_unix_s=record.made_unix_s,
        )
        await self._victims.add(VictimRecord(victim_id, place, 1.0, 0, (), 0.0, 0.0, words))
        return f"It is victim {victim_id}."

    async def _take_mayday(self, record: ReportRecord, said: ReportIn) -> str:
        late_s = record.received_unix_s - record.made_unix_s
        ago_min = round(late_s / 60) if late_s > _LATE_S else 0
        await call_for_help(self._alerts, record.by, said.text, said.tag_id, ago_min)
        return "Everybody was told."

    async def _take_heard(self, record: ReportRecord, said: ReportIn) -> str:
        if self._evacuation.value()["since_unix_s"] != said.since_unix_s:
            return "That order is over."  # and a later one has to be heard by itself
        try:
            await self._evacuation.acknowledge(record.by)
        except ApiError:
            return "That order is over."
        return "It was noted."

    async def _take_at(self, record: ReportRecord, said: ReportIn) -> str:
        self._show_place(record)
        self._walks.take(record.body)
        text = too_far(self._board, record.by, said)
        if text is None:
            return "It was noted."
        subject = f"{said.tag_id} twice"
        await self._alerts.raise_("tag", subject, text, "warning", event="tag_twice", tag_id=said.tag_id)
        return text

    def _show_place(self, record: ReportRecord) -> None:
        key = f"responder/{record.by}"
        known = self._board.get(key)
        if known is None or known["unix_s"] < record.made_unix_s:
            place = {"name": record.by, "tag_id": record.body["tag_id"], "unix_s": record.made_unix_s}
            self._board.publish({key: place})


def made_at(said: ReportIn, now: float) -> float:
    """Return when a report was made, by the server's clock, of which it is ``now``.

    By what the phone knew of its clock then; else by how far that clock has gone on since.
    """
    offset_s = now - said.sent_phone_unix_s if said.offset_s is None else said.offset_s
    return min(said.phone_unix_s + offset_s, now)


def _signature(said: ReportIn, sender: str) -> str:
    if said.is_carried:
        return f"{said.made_by or 'somebody'} (carried by {sender})"
    return sender if said.made_by in ("", sender) else f"{said.made_by} (sent by {sender})"


def _values(record: ReportRecord) -> dict[str, Any]:
    return {name: getattr(record, name) for name in ReportRecord.__slots__}
