"""Holding the process that makes a best map as soon as it is there: polling for it can come too late."""

import asyncio
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Queue

import psutil
import pytest

from server.agents.best_servant import NICENESS
from server.agents.forkserver import BEST
from server.agents.process import ForkServer, Worker


@contextmanager
def best_maps_held() -> Iterator["Queue[int]"]:
    """The pids of those that come while this lasts, each stopped before it has been asked anything."""
    spawned: Queue[int] = Queue()
    really_spawn = ForkServer.spawn

    async def spawn(forks: ForkServer, role: bytes) -> Worker:
        worker = await really_spawn(forks, role)
        if role == BEST:
            while psutil.Process(worker.pid).nice() != NICENESS:  # it has not begun
                await asyncio.sleep(0.01)
            os.kill(worker.pid, signal.SIGSTOP)
            spawned.put(worker.pid)
        return worker

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ForkServer, "spawn", spawn)
        yield spawned
