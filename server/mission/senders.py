"""Two robots that send under one name: told by an observation that came twice and differs."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import fields, replace
from math import inf

from db.records import ObservationRecord
from db.store import Store
from robots import codec
from robots.types import Observation
from server.mission.events import Events
from server.robot import Robot

_AGAIN_S = 60.0  # two that go on are no news for so long
_SHOWN_FIELDS = 3


class Senders:
    """From where each robot sends.

    Sending again is no offence, sending something else under a known seq is.
    """

    def __init__(self, store: Store, mission_id: str, events: Events) -> None:
        self._store = store
        self._mission_id = mission_id
        self._events = events
        self._accepted: dict[str, str] = {}  # robot -> whose observations were accepted last
        self._told_s: dict[str, float] = {}

    async def check(self, robot: Robot, batch: Sequence[Observation], fresh: int, sender: str) -> None:
        """Compare the newest observation of a batch that was known already with the one in the log."""
        name, known = robot.robot_id, batch[: len(batch) - fresh]
        before = self._accepted.get(name, sender)
        if fresh:
            self._accepted[name] = sender
        if not known or time.monotonic() - self._told_s.get(name, -inf) < _AGAIN_S:
            return
        seq = known[-1].seq
        async for record in self._store.log.observations_after(self._mission_id, name, seq - 1, seq):
            if record.body != codec.encode(known[-1]) and _differs(record, known[-1]):
                self._told_s[name] = time.monotonic()
                text = _text(name, record, known[-1], before, sender)
                await self._events.tell("name_shared", text, name, "alarm")


def _differs(record: ObservationRecord, other: Observation) -> bool:
    """Say whether more differs than what the server added: orders, and messages of the team."""
    kept = codec.decode(record.body, Observation)
    return codec.encode(replace(kept, heard=other.heard, orders=other.orders)) != codec.encode(other)


def _text(name: str, record: ObservationRecord, other: Observation, before: str, sender: str) -> str:
    kept = codec.decode(record.body, Observation)
    if kept.stamp_s != other.stamp_s:
        what = f"its clock says {kept.stamp_s:.2f} s in one and {other.stamp_s:.2f} s in the other"
    else:
        differing = [
            item.name
            for item in fields(Observation)
            if codec.encode(getattr(kept, item.name)) != codec.encode(getattr(other, item.name))
        ]
        what = f"they differ in {', '.join(differing[:_SHOWN_FIELDS])}"
    whence = f" One sends from {before}, the other from {sender}." if before != sender else ""
    return (
        f"Two robots send as {name}: observation {other.seq} came twice, and {what}. The first is kept."
        f"{whence} Stop {name} and register one of them under another name:"
        " each gets orders meant for the other."
    )
