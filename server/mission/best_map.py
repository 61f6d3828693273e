"""The best map: a batch solve of everything that was recorded, beside the live map and without touching it.

It is made when somebody asks, of snapshots of the agents, and kept until the next one is there.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import structlog

from db.errors import DatabaseError
from db.store import Store
from server.agents.best import BestHost, BestShare
from server.agents.process import ForkServer, WorkerDiedError, WorkerFailedError
from server.best_sharing import SharedBestMap, shared
from server.board import Board
from server.errors import ApiError
from server.map_image import MapImage
from server.mission.roster import Roster
from server.mission.shared_map import SharedMap
from server.mission.tasks import Tasks
from server.robot import Robot

BestMapState = Literal["none", "solving", "ready", "failed"]

_SNAPSHOT_S = 20.0  # an agent that takes longer is represented by the last snapshot that was kept
_UNASKED = "Nobody has asked for a best map yet."

log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class _Work:
    """How the making of a best map stands."""

    state: BestMapState = "none"
    reason: str = _UNASKED
    asked_unix_s: float | None = None
    robots_done: int = 0
    robots_total: int = 0


class BestMap:
    """Makes the best map of a mission, one at a time, and tells the board (``best_map``) how it stands.

    ``image`` is the picture of the latest one.
    """

    def __init__(
        self,
        store: Store,
        forks: ForkServer,
        board: Board,
        roster: Roster,
        shared_map: SharedMap,
        tasks: Tasks,
    ) -> None:
        self._store = store
        self._board = board
        self._roster = roster
        self._shared_map = shared_map
        self._tasks = tasks
        self._host = BestHost(forks)
        self._work = _Work()
        self._made = SharedBestMap()
        self._mission_id = roster.record.mission_id

    @property
    def pid(self) -> int | None:
        """The process that is making a best map now."""
        return self._host.pid

    @property
    def image(self) -> MapImage | None:
        """The picture of the latest best map, None while there is none."""
        return self._made.image

    @property
    def is_current(self) -> bool:
        """Whether it is there, with every observation up to now in it."""
        seen = {robot.robot_id: robot.next_seq - 1 for robot in self._observers()}
        return self._work.state == "ready" and self._made.as_of == seen

    def ask(self) -> None:
        """Have a best map made, unless one is being made, or the one that is there cannot become better.

        Raises:
            ApiError: no robot has observed anything.
        """
        if self._work.state == "solving" or self.is_current:
            return
        robots = self._observers()
        if not robots:
            text = "No robot has observed anything yet; ask for the best map when one has."
            raise ApiError(409, "nothing_observed", text)
        self._publish(_Work("solving", "", time.time(), 0, len(robots)))
        self._tasks.spawn(self._make(robots))

    def value(self) -> dict[str, Any]:
        """Return ``best_map`` of the board: how it stands, and the latest one that is there in short."""
        work = {name: getattr(self._work, name) for name in _Work.__slots__}
        return {**work, **self._made.short}

    def details(self) -> dict[str, Any]:
        """Return robots with their trails, tags, links and victims of the latest one."""
        return dict(self._made.details)

    def _observers(self) -> list[Robot]:
        return [robot for robot in self._roster.robots.values() if robot.next_seq > 0]

    def _publish(self, work: _Work) -> None:
        self._work = work
        self._board.publish({"best_map": self.value()})

    async def _make(self, robots: Sequence[Robot]) -> None:
        """Make it; whatever happens, the state says how that ended."""
        try:
            reason = await self._try(robots)
        except WorkerFailedError as error:
            log.error("best map failed", mission_id=self._mission_id, reason=str(error))
            reason = "The solve ended with an error, which is in the server's log; ask again."
        except WorkerDiedError as error:
            log.warning("best map process lost", mission_id=self._mission_id, reason=str(error))
            reason = "The process that made the best map ended before it was done; ask again."
        except DatabaseError as error:
            log.error("best map failed", mission_id=self._mission_id, reason=str(error))
            reason = f"The database could not be read: {error}"
        except Exception:
            log.exception("best map failed", mission_id=self._mission_id)
            reason = "The server has a fault, which is in its log; ask again."
        self._publish(replace(self._work, state="failed" if reason else "ready", reason=reason))

    async def _try(self, robots: Sequence[Robot]) -> str:
        """Make it and keep it; return why there is none, nothing when there is."""
        snapshots = await asyncio.gather(*map(self._snapshot, robots))
        shares, left_out = [], {}
        for robot, snapshot in zip(robots, snapshots, strict=True):
            name = robot.robot_id
            if snapshot is None:
                left_out[name] = "its agent does not run and has left no snapshot"
                continue
            seq, body = snapshot
            way = self._shared_map.way(name, seq)
            shares.append(BestShare(name, robot.record.start_pose, body, way))
        if shares:
            solution = await self._host.solve(shares, self._smoothed)
            left_out |= solution.left_out
            if solution.robots:
                self._made = await asyncio.to_thread(
                    shared, self._mission_id, solution, left_out, self._made.image
                )
                return ""
        reasons = "; ".join(f"{name}: {why}" for name, why in sorted(left_out.items()))
        return f"No robot's recording could be used ({reasons}); ask again in a minute."

    def _smoothed(self, robots: int) -> None:
        self._publish(replace(self._work, robots_done=robots))

    async def _snapshot(self, robot: Robot) -> tuple[int, bytes] | None:
        """Return an agent's state now, or the last one that was kept where it does not run or answer."""
        if robot.host.pid is not None:
            # Not cancelled when it takes too long: that would cost the agent its process.
            asking = self._tasks.spawn(_taken_now(robot))
            await asyncio.wait({asking}, timeout=_SNAPSHOT_S)
            if asking.done() and (snapshot := asking.result()) is not None:
                return snapshot
        kept = await self._store.log.latest_snapshot(self._mission_id, robot.robot_id)
        return None if kept is None else (kept.seq, kept.body)


async def _taken_now(robot: Robot) -> tuple[int, bytes] | None:
    try:
        return await robot.host.snapshot()
    except (WorkerDiedError, DatabaseError) as error:
        log.warning("no snapshot for the best map", robot_id=robot.robot_id, reason=str(error))
        return None
