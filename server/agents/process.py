"""Worker processes as the server's event loop sees them: forked on demand, asked one thing at a time."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import cast

from server.agents.frames import Frame, Kind, pack, take

_PID_BYTES = 4


class WorkerDiedError(Exception):
    """The worker process ended, failed or did not answer in time; its state is lost."""


class WorkerFailedError(WorkerDiedError):
    """The worker could not do what it was asked and ended; the message is its traceback."""


class Worker(asyncio.Protocol):
    """One worker process. Asking it one thing at a time is the caller's duty."""

    def __init__(self) -> None:
        self.pid = 0
        self.lost = asyncio.Event()
        self._buffer = bytearray()
        self._answer: asyncio.Future[Frame] | None = None
        self._transport: asyncio.Transport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the way to the process."""
        self._transport = cast(asyncio.Transport, transport)  # uvloop's is one without being its subclass

    def data_received(self, data: bytes) -> None:
        """Collect an answer."""
        self._buffer += data
        frame = take(self._buffer)
        if frame is not None and self._answer is not None and not self._answer.done():
            self._answer.set_result(frame)

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell who waits that the process is gone."""
        self.lost.set()
        if self._answer is not None and not self._answer.done():
            self._answer.set_exception(WorkerDiedError(f"process {self.pid} ended"))

    async def ask(self, kind: Kind, parts: Sequence[bytes] = (), *, timeout_s: float) -> list[bytes]:
        """Send a frame and return the parts of the answer.

        Raises:
            WorkerDiedError: no answer; the process is ended then.
        """
        if self.lost.is_set() or self._transport is None:
            raise WorkerDiedError(f"process {self.pid} ended")
        self._answer = asyncio.get_running_loop().create_future()
        try:
            self._transport.write(pack(kind, parts))
            answer_kind, answer = await asyncio.wait_for(self._answer, timeout_s)
        except TimeoutError as error:
            self.kill()
            raise WorkerDiedError(f"process {self.pid} gave no answer for {timeout_s:.0f} s") from error
        except asyncio.CancelledError:
            self.kill()  # its answer would be taken for the answer to the next question
            raise
        finally:
            self._answer = None
        if answer_kind is Kind.FAILED:
            self.kill()
            raise WorkerFailedError(answer[0].decode(errors="replace"))
        return answer

    def kill(self) -> None:
        """End the process at once."""
        if not self.lost.is_set():
            with suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)
        self.close()

    def close(self) -> None:
        """Close the connection; the process ends when it sees that."""
        if self._transport is not None:
            self._transport.abort()


class ForkServer:
    """Starts workers by asking a process that has everything loaded; it is started itself on first use."""

    def __init__(self, agent_module: str = "robots.agent", team_module: str = "robots.team") -> None:
        self._modules = (agent_module, team_module)
        self._lock = asyncio.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._closed = False

    async def start(self) -> None:
        """Start the forking process now, so that it loads while nobody waits."""
        async with self._lock:
            if self._control is None and not self._closed:
                await asyncio.to_thread(self._launch)

    async def spawn(self, role: bytes) -> Worker:
        """Return a new worker process.

        Raises:
            WorkerDiedError: the forking process died twice in a row.
        """
        # Shielded: a request that is given up half way would leave its reply for the next one.
        spawning = asyncio.create_task(self._spawn(role))
        try:
            return await asyncio.shield(spawning)
        except asyncio.CancelledError:
            spawning.add_done_callback(_discard)
            raise

    async def close(self) -> None:
        """End the forking process and with it every worker."""
        self._closed = True
        if self._control is not None:
            self._control.shutdown(socket.SHUT_RDWR)  # wakes a request that waits for it to finish loading
        async with self._lock:
            await self._stop()

    async def _spawn(self, role: bytes) -> Worker:
        async with self._lock:
            for _ in range(2):
                if self._closed:
                    raise WorkerDiedError("the server is closing")
                if self._control is None:
                    await asyncio.to_thread(self._launch)
                with suppress(OSError, EOFError):
                    return await self._fork(role)
                await self._stop()
        raise WorkerDiedError("the process that starts agents died twice; see the messages above")

    def _launch(self) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            self._process = begin(theirs.fileno(), *self._modules)
        ours.setblocking(False)
        self._control = ours

    async def _fork(self, role: bytes) -> Worker:
        assert self._control is not None
        loop = asyncio.get_running_loop()
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                socket.send_fds(self._control, [role], [theirs.fileno()])
            reply = b""
            while len(reply) < _PID_BYTES:
                data = await loop.sock_recv(self._control, _PID_BYTES - len(reply))
                if not data:
                    raise EOFError
                reply += data
            ours.setblocking(False)
            _, worker = await loop.create_unix_connection(Worker, sock=ours)
        except BaseException:
            ours.close()
            raise
        worker.pid = int.from_bytes(reply, "little", signed=True)
        return worker

    async def _stop(self) -> None:
        process, control = self._process, self._control
        self._process = self._control = None
        if control is not None:
            control.close()
        if process is not None:
            try:
                await asyncio.to_thread(process.wait, 1.5)
            except subprocess.TimeoutExpired:  # still loading
                process.kill()
                await asyncio.to_thread(process.wait)


def begin(control_fd: int, agent_module: str, team_module: str) -> subprocess.Popen[bytes]:
    """Start the process that loads both modules and then forks a worker for every request on a socket."""
    return python(
        f"from server.agents.forkserver import main; main({control_fd}, {agent_module!r}, {team_module!r})",
        control_fd,
    )


def python(code: str, control_fd: int) -> subprocess.Popen[bytes]:
    """Run code that needs a socket in a process to fork from."""
    # A session of its own: Ctrl-C in the terminal reaches the server only. One BLAS thread: threads do not
    # survive a fork.
    return subprocess.Popen(
        [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; {code}"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        pass_fds=[control_fd],
        start_new_session=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
    )


def _discard(spawning: asyncio.Task[Worker]) -> None:
    if not spawning.cancelled() and spawning.exception() is None:
        spawning.result().kill()
