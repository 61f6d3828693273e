"""One process with everything loaded, of which the tests' servers have theirs that fork agents.

Each server has a process that loads the agent and its kernels: some three seconds of a processor, and tests
start more than a hundred servers. Here it is loaded once; what a server gets is forked from it and runs the
same ``main``, in a session of its own. Tests that start ``waymark`` as a process load it all, as people do.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from server.agents import forkserver, process


class Forked:
    """What ``ForkServer`` asks of a process that it started."""

    def __init__(self, pid: int) -> None:
        self._fd = os.pidfd_open(pid)
        self._ended = select.poll()
        self._ended.register(self._fd, select.POLLIN)

    def wait(self, timeout: float | None = None) -> None:
        """Wait for its end, ``timeout`` seconds at most.

        Raises:
            subprocess.TimeoutExpired: it still runs.
        """
        if not self._ended.poll(None if timeout is None else 1000.0 * timeout):
            raise subprocess.TimeoutExpired("a fork server", timeout or 0.0)
        os.close(self._fd)

    def kill(self) -> None:
        """End it at once."""
        signal.pidfd_send_signal(self._fd, signal.SIGKILL)


class Loaded:
    """The process that has everything loaded, started when the first server is."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket

    def begin(self, control_fd: int, agent_module: str, team_module: str) -> Forked:
        """Do as ``server.agents.process.begin``."""
        with self._lock:
            if self._process is None:
                self._start()
            words = f"{agent_module} {team_module}".encode()
            socket.send_fds(self._control, [words], [control_fd])
            return Forked(forkserver.PID.unpack(self._control.recv(forkserver.PID.size))[0])

    def close(self) -> None:
        """End it."""
        if self._process is not None:
            self._control.close()
            self._process.wait()

    def _start(self) -> None:
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            fd = theirs.fileno()
            self._process = process.python(f"from tests.loaded import lend; lend({fd})", fd)


def lend(control_fd: int) -> None:
    """Load everything, then fork a ``forkserver.main`` for every socket that comes, until no more can."""
    import robots.agent
    import robots.team  # noqa: F401 - loaded for those that are forked from here

    forkserver.warm_up()
    with socket.socket(fileno=control_fd) as control:
        while True:
            words, fds, _, _ = socket.recv_fds(control, 1024, 1)
            if not fds:
                return
            _reap()
            pid = os.fork()
            if pid == 0:
                _run(control, fds[0], words)
            os.close(fds[0])
            control.send(forkserver.PID.pack(pid))


def _run(control: socket.socket, control_fd: int, words: bytes) -> None:
    """Be a process that forks agents, as ``server.agents.process.begin`` starts one."""
    code = 1
    try:
        control.close()
        os.setsid()
        forkserver.main(control_fd, *words.decode().split())
        code = 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        os._exit(code)  # the exit handlers are those of the process that it was forked from


def _reap() -> None:
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:  # there is none
        pass


def _has_pidfd() -> bool:
    try:
        os.close(os.pidfd_open(os.getpid()))
    except (AttributeError, OSError):
        return False
    return True


def servers_fork_from_one() -> Iterator[None]:
    """Have all servers of this process fork from one that is loaded, where there are handles of processes."""
    if not _has_pidfd():
        yield  # macOS and older kernels: each server loads its own
        return
    loaded = Loaded()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(process, "begin", loaded.begin)
        yield
    loaded.close()
