"""What one person changes, until all others who watch have it: from the request to each one's socket."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any
from uuid import uuid4

import httpx
import numpy as np
from websockets.asyncio.client import connect

Values = dict[str, Any]
_ROBOT, _ROUNDS, _PAUSE_S, _PATIENCE_S = "changed", 20, 0.1, 60.0
_CORNERS = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]
_STILL = {"kind": "displacement", "dx_m": 0.0, "dy_m": 0.0, "dtheta_rad": 0.0}


@dataclass(frozen=True, slots=True)
class Change:
    """A request, and how a watcher recognises what came of it among the values that are new to them."""

    name: str
    method: str
    path: str
    body: Values
    holds: Callable[[Values], Any]


@dataclass(slots=True)
class _Wanted:
    """What all watchers wait for, how many have it, and when the last of them had (seconds, monotonic)."""

    holds: Callable[[Values], Any] = lambda values: False
    have_it: int = 0
    at_s: float = 0.0
    all_have_it: asyncio.Event = field(default_factory=asyncio.Event)


async def measure(home: str, mission: str, watchers: int) -> dict[str, float]:
    """Return for every kind of change how long the last of all watchers waited for it, in ms.

    Its median, 95th percentile and worst over all rounds.
    """
    at = f"{home}/api/v1/missions/{mission}"
    wanted, there = _Wanted(), asyncio.Semaphore(0)
    async with httpx.AsyncClient(timeout=_PATIENCE_S) as client, asyncio.TaskGroup() as group:
        (await client.post(f"{at}/robots", json={"robot_id": _ROBOT})).raise_for_status()
        address = at.replace("http", "ws", 1) + "/stream"
        watching = [group.create_task(_watch(address, wanted, watchers, there)) for _ in range(watchers)]
        for _ in watching:
            await there.acquire()
        delays: dict[str, list[float]] = {}
        for k in range(_ROUNDS):
            await _speak(client, at, k)  # so that no orders pile up
            for change in _changes(k):
                delays.setdefault(change.name, []).append(await _make(client, at, change, wanted))
            (await client.delete(f"{at}/alerts/mayday/operator")).raise_for_status()
        for task in watching:
            task.cancel()
    told = {}
    for name, found in delays.items():
        told[f"{name} to all watchers p50, ms"] = float(np.median(found))
        told[f"{name} to all watchers p95, ms"] = float(np.percentile(found, 95))
        told[f"{name} to all watchers worst, ms"] = max(found)
    return told


async def _make(client: httpx.AsyncClient, at: str, change: Change, wanted: _Wanted) -> float:
    """Make a change; return after how many ms the last watcher had it."""
    wanted.holds, wanted.have_it = change.holds, 0
    wanted.all_have_it.clear()
    began_s = time.monotonic()
    response = await client.request(change.method, at + change.path, json=change.body)
    response.raise_for_status()
    async with asyncio.timeout(_PATIENCE_S):
        await wanted.all_have_it.wait()
    await asyncio.sleep(_PAUSE_S)
    return 1e3 * (wanted.at_s - began_s)


async def _watch(address: str, wanted: _Wanted, watchers: int, there: asyncio.Semaphore) -> None:
    """Read the stream, and note when what is wanted comes; until cancelled."""
    async with connect(address, max_size=None) as stream:
        await stream.recv()  # what was there before
        there.release()
        seen: Callable[[Values], Any] | None = None
        async for text in stream:
            now_s = time.monotonic()
            if wanted.holds is seen or not wanted.holds(json.loads(text)["set"]):
                continue
            seen = wanted.holds
            wanted.have_it, wanted.at_s = wanted.have_it + 1, now_s
            if wanted.have_it == watchers:
                wanted.all_have_it.set()


async def _speak(client: httpx.AsyncClient, at: str, k: int) -> None:
    """Have the one real robot, beside those that only the board has, say its k-th observation."""
    body = {"observations": [{"seq": k, "stamp_s": 0.2 * k, "odometry": _STILL}]}
    while (answer := await client.post(f"{at}/robots/{_ROBOT}/observations", json=body)).status_code == 503:
        await asyncio.sleep(1.0)  # its agent is being loaded
    answer.raise_for_status()


def _changes(k: int) -> list[Change]:
    """Return what is changed in a round, one after the other."""
    note, sector, kind = uuid4(), uuid4(), ("hold", "resume")[k % 2]
    alert = "mayday:operator"
    words = {"kind": "hazard", "text": "gas", "x_m": 1.0, "y_m": 2.0}

    def stands(values: Values, stopped: bool) -> bool:
        robot = values.get(f"robot/{_ROBOT}")
        return robot is not None and robot["stopped"] is stopped

    return [
        Change("a note", "PUT", f"/annotations/{note}", words, lambda v: f"annotation/{note}" in v),
        Change("a note moved", "PUT", f"/annotations/{note}", {**words, "x_m": 3.0},
               lambda v: f"annotation/{note}" in v),
        Change("a sector", "PUT", f"/sectors/{sector}", {"name": f"S{k}", "area_m": _CORNERS},
               lambda v: f"sector/{sector}" in v),
        Change("an order", "POST", f"/robots/{_ROBOT}/orders", {"kind": kind},
               lambda v: f"orders/{_ROBOT}" in v),
        Change("a MAYDAY", "POST", "/alerts/mayday", {}, lambda v: f"alert/{alert}" in v),
        Change("its acknowledgement", "POST", f"/alerts/{alert}/acknowledge", {},
               lambda v: (v.get(f"alert/{alert}") or {}).get("acknowledged_by")),
        Change("STOP", "POST", "/stop", {"robots": [_ROBOT]}, lambda v: stands(v, True)),
        Change("resume", "POST", "/resume", {"robots": [_ROBOT]}, lambda v: stands(v, False)),
    ]  # fmt: skip
