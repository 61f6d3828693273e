"""The team map of a mission in a process of its own.

It is a function of the set of the robots' latest graphs, submaps and victims, so whatever happens to the
process, a new one is told them all again and comes to the same map.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass, field, replace

import numpy as np
import structlog

from db.records import StartPoseRecord
from robots import codec
from robots.graph_report import GraphReport
from robots.se2 import Array
from robots.team import TeamUpdate
from robots.types import AgentUpdate, SubmapReport, VictimEstimate
from server.agents.forkserver import TEAM
from server.agents.frames import Kind
from server.agents.process import ForkServer, Worker

_PERIOD_S = 0.5  # the map is solved at most this often
_STARTING_S, _ASKING_S = 90.0, 60.0
_LONGEST_PAUSE_S = 5.0

_STEP_M = 0.25  # of the trail
_NO_PATH = np.zeros((0, 2), np.float32)
_NO_PATH.flags.writeable = False

_Step = tuple[int, int, int]  # an anchor, and a cell round it

log = structlog.get_logger()


@dataclass(slots=True)
class _Share:
    """What one robot contributes: the latest of everything, and what the process has not been told."""

    start: StartPoseRecord | None
    latest: AgentUpdate | None = None
    graph: GraphReport | None = None
    submaps: dict[int, SubmapReport] = field(default_factory=dict)
    victims: dict[str, VictimEstimate] = field(default_factory=dict)
    steps: dict[_Step, AgentUpdate] = field(default_factory=dict)
    is_new: bool = True
    graph_changed: bool = False
    submaps_changed: set[int] = field(default_factory=set)
    victims_changed: set[str] = field(default_factory=set)
    steps_changed: set[_Step] = field(default_factory=set)

    @property
    def changed(self) -> bool:
        return self.is_new or self.graph_changed or bool(self.submaps_changed or self.victims_changed)

    def put(self, update: AgentUpdate) -> None:
        """Take over what an update brings; the latest replaces the earlier."""
        self.latest = update
        place = update.anchor_from_base
        step = (update.anchor, round(place.x / _STEP_M), round(place.y / _STEP_M))
        if step not in self.steps:  # by steps, and all of them: a backlog must not cut the trail short
            self.steps[step] = replace(update, graph=None, submaps=(), victims=(), path_m=_NO_PATH)
            self.steps_changed.add(step)
        if update.graph is not None:
            self.graph, self.graph_changed = update.graph, True
        for submap in update.submaps:
            self.submaps[submap.anchor] = submap
            self.submaps_changed.add(submap.anchor)
        for victim in update.victims:
            self.victims[victim.victim_id] = victim
            self.victims_changed.add(victim.victim_id)

    def forget_told(self) -> None:
        """Begin again: nothing has been told."""
        self.is_new, self.graph_changed = True, self.graph is not None
        self.submaps_changed, self.victims_changed = set(self.submaps), set(self.victims)
        self.steps_changed = set(self.steps)

    def take(self) -> list[AgentUpdate]:
        """Return what has not been told, and count it as told."""
        if self.latest is None:
            self.is_new = False
            return []
        steps = sorted((self.steps[step] for step in self.steps_changed), key=lambda update: update.seq)
        latest, graph = self.latest, self.graph if self.graph_changed else None
        submaps = tuple(self.submaps[anchor] for anchor in sorted(self.submaps_changed))
        victims = tuple(self.victims[victim_id] for victim_id in sorted(self.victims_changed))
        self.is_new = self.graph_changed = False
        self.submaps_changed, self.victims_changed, self.steps_changed = set(), set(), set()
        return [*steps, replace(latest, graph=graph, submaps=submaps, victims=victims)]


class TeamHost:
    """Feeds the team map and passes its solutions on.

    At most twice a second, only when something changed, and not before ``begin``.
    """

    def __init__(
        self, forks: ForkServer, on_update: Callable[[TeamUpdate], Awaitable[None]], *, name: str
    ) -> None:
        self._forks = forks
        self._on_update = on_update
        self._name = name
        self._shares: dict[str, _Share] = {}
        self._begun = asyncio.Event()
        self._changed = asyncio.Event()
        self._solving = False
        self._worker: Worker | None = None
        self._task = asyncio.create_task(self._run(), name=f"team map of {name}")

    @property
    def pid(self) -> int | None:
        """The process that holds the team map now."""
        return None if self._worker is None or self._worker.lost.is_set() else self._worker.pid

    def add_robot(self, robot_id: str, start: StartPoseRecord | None) -> None:
        """Add a robot, with its surveyed start if there is one."""
        self._shares[robot_id] = _Share(start)
        self._changed.set()

    def put(self, robot_id: str, update: AgentUpdate) -> None:
        """Take over an agent's update.

        Only one that brings graph, submaps or victims makes the map change.
        """
        share = self._shares[robot_id]
        share.put(update)
        if share.changed:
            self._changed.set()

    def way(self, robot_id: str, until_seq: int) -> Array:
        """Return where a robot was up to an observation, as ``server.agents.best`` takes it: shape (n, 6)."""
        share = self._shares.get(robot_id)  # none where the mission is over
        steps = [step for step in share.steps.values() if step.seq <= until_seq] if share else []
        rows = [(s.seq, s.stamp_s, s.anchor, *s.anchor_from_base.as_array()) for s in steps]
        return np.array(rows, np.float64).reshape(-1, 6)

    def submaps(self, robot_id: str) -> list[SubmapReport]:
        """Return the latest submaps of a robot."""
        return list(self._shares[robot_id].submaps.values()) if robot_id in self._shares else []

    def begin(self) -> None:
        """Solve from now on."""
        self._begun.set()

    async def settled(self) -> None:
        """Wait until everything that was put is in a map that was passed on."""
        while self._changed.is_set() or self._solving:
            await asyncio.sleep(0.05)

    async def close(self) -> None:
        """End the process."""
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)
        if self._worker is not None:
            self._worker.kill()

    async def _run(self) -> None:
        failures = 0
        await self._begun.wait()
        while True:
            await self._changed.wait()
            self._changed.clear()
            self._solving = True
            began_s = time.monotonic()
            try:
                update = await self._solve()
                failures = 0
            except Exception as error:  # whatever it is, the map must not end for it
                failures += 1
                if self._worker is not None:
                    self._worker.kill()
                    self._worker = None
                log.warning(
                    "team map process lost", mission_id=self._name, reason=repr(error), failures=failures
                )
                self._changed.set()
                if failures > 1:
                    await asyncio.sleep(min(0.05 * 2.0 ** (failures - 1), _LONGEST_PAUSE_S))
                continue
            try:
                await self._on_update(update)
            except Exception:  # the next solution is independent of this one
                log.exception("a team map could not be published", mission_id=self._name)
            self._solving = False
            await asyncio.sleep(max(0.0, _PERIOD_S - (time.monotonic() - began_s)))

    async def _solve(self) -> TeamUpdate:
        if self._worker is None or self._worker.lost.is_set():
            for share in self._shares.values():
                share.forget_told()
            self._worker = await self._forks.spawn(TEAM)
            await self._worker.ask(Kind.BEGIN, timeout_s=_STARTING_S)
        worker = self._worker
        for robot_id, share in list(self._shares.items()):
            if not share.changed:
                continue
            is_new, start = share.is_new, share.start
            updates = share.take()
            if is_new:
                told = b"" if start is None else json.dumps(asdict(start)).encode()
                await worker.ask(Kind.ADD_ROBOT, [robot_id.encode(), told], timeout_s=_ASKING_S)
            if updates:
                parts = [robot_id.encode(), *map(codec.encode, updates)]
                await worker.ask(Kind.PUT, parts, timeout_s=_ASKING_S)
        return codec.decode((await worker.ask(Kind.SOLVE, timeout_s=_ASKING_S))[0], TeamUpdate)
