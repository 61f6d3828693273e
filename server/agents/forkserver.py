"""The process that forks workers: a new one is there in milliseconds, with everything imported and compiled.

``multiprocessing``'s fork server would import the program's main module into every worker, and speaks to them
over blocking pipes. This one loads the modules it is told, and each worker gets one end of a socket pair that
the server's event loop reads. A worker ends when its socket closes, and this process ends its workers when
the server is gone, however it went. Runs as ``python -c "...main(fd, agent_module, team_module)"``.
"""

from __future__ import annotations

import importlib
import os
import select
import signal
import socket
import struct
import sys
import time
from types import ModuleType

from robots.warmup import warm_up
from server.agents.best_servant import BestServant
from server.agents.worker import AgentServant, Servant, TeamServant, serve

PID = struct.Struct("<i")
AGENT, TEAM, BEST = b"a", b"t", b"b"
_TEAM_NICENESS = 5  # the map may come a moment later; a robot waits for its order
_PATIENCE_S = 1.0  # for a worker in the middle of a step when the server is gone


def main(control_fd: int, agent_module: str, team_module: str) -> None:
    """Fork a worker for every request on the control socket until it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's to handle
    agent, team = importlib.import_module(agent_module), importlib.import_module(team_module)
    try:
        warm_up()  # what is compiled or loaded here, every worker has
    except Exception as error:  # it costs time later, nothing else
        print(f"waymark: the warm-up failed: {error!r}", file=sys.stderr)
    children: set[int] = set()
    with socket.socket(fileno=control_fd) as control:
        waiting = select.poll()  # ``select`` refuses descriptors beyond 1023
        waiting.register(control, select.POLLIN)
        while True:
            ready = waiting.poll(1000)
            children -= _ended(children)
            if not ready:
                continue
            try:
                role, fds, _, _ = socket.recv_fds(control, 1, 1)
                if not role:
                    break
                pid = _fork(control, fds[0], role, agent, team)
                os.close(fds[0])
                children.add(pid)
                control.sendall(PID.pack(pid))
            except OSError:  # the server is gone
                break
    _end(children)


def _fork(control: socket.socket, fd: int, role: bytes, agent: ModuleType, team: ModuleType) -> int:
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        control.close()
        with socket.socket(fileno=fd) as connection:
            code = serve(connection, _servant(role, agent, team))
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        os._exit(code)  # a forked child must not run the parent's exit handlers


def _servant(role: bytes, agent: ModuleType, team: ModuleType) -> Servant:
    if role == AGENT:
        return AgentServant(agent)
    if role == TEAM:
        os.nice(_TEAM_NICENESS)
    return TeamServant(team) if role == TEAM else BestServant(agent, team)


def _ended(children: set[int]) -> set[int]:
    return {pid for pid in children if os.waitpid(pid, os.WNOHANG)[0]}


def _end(children: set[int]) -> None:
    """Give workers a moment to see their sockets close, then end those that are stuck."""
    deadline = time.monotonic() + _PATIENCE_S
    while children and time.monotonic() < deadline:
        children -= _ended(children)
        time.sleep(0.01)
    for pid in children:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
