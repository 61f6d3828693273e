"""The best map of a mission, made on demand in a process of its own that ends afterwards."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

from db.records import StartPoseRecord
from robots import codec
from robots.se2 import Array
from robots.team import TeamUpdate
from robots.types import AgentUpdate
from server.agents.forkserver import BEST
from server.agents.frames import Kind
from server.agents.process import ForkServer, Worker
from server.agents.worker import TAKEN

_ROBOT_S = _SOLVE_S = 900.0  # seconds of work, which others may keep waiting for long


@dataclass(frozen=True, slots=True, eq=False)
class BestShare:
    """What a robot brings to the best map: its surveyed start, its agent's snapshot, and its way.

    ``way`` (n, 6): seq, stamp, anchor, and the base in the anchor's frame (x, y, heading) of each step.
    """

    robot_id: str
    start: StartPoseRecord | None
    snapshot: bytes
    way: Array


@dataclass(frozen=True, slots=True, eq=False)
class BestSolution:
    """A best map.

    ``robots``: how each stood at the last observation that is in the map; ``left_out``: who is not in it, and
    why.
    """

    team: TeamUpdate
    robots: Mapping[str, AgentUpdate]
    left_out: Mapping[str, str]


class BestHost:
    """Has best maps made, one at a time."""

    def __init__(self, forks: ForkServer) -> None:
        self._forks = forks
        self._worker: Worker | None = None

    @property
    def pid(self) -> int | None:
        """The process that is making a best map now."""
        return None if self._worker is None or self._worker.lost.is_set() else self._worker.pid

    async def solve(self, shares: Sequence[BestShare], on_smoothed: Callable[[int], None]) -> BestSolution:
        """Return the best map of robots; ``on_smoothed`` is told how many of them are done.

        Raises:
            WorkerDiedError: the process died, failed, or took too long.
        """
        robots: dict[str, AgentUpdate] = {}
        left_out: dict[str, str] = {}
        worker = self._worker = await self._forks.spawn(BEST)
        try:
            for number, share in enumerate(shares, 1):
                start = b"" if share.start is None else json.dumps(asdict(share.start)).encode()
                parts = [share.robot_id.encode(), start, share.snapshot, share.way.tobytes()]
                (said,) = await worker.ask(Kind.ADD_ROBOT, parts, timeout_s=_ROBOT_S)
                if said[:1] == TAKEN:
                    robots[share.robot_id] = codec.decode(said[1:], AgentUpdate)
                else:
                    left_out[share.robot_id] = said[1:].decode()
                on_smoothed(number)
            (said,) = await worker.ask(Kind.SOLVE, timeout_s=_SOLVE_S)
        finally:
            worker.kill()
            self._worker = None
        return BestSolution(await asyncio.to_thread(codec.decode, said, TeamUpdate), robots, left_out)
