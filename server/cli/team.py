"""A simulated team in a process of its own, which reaches mission control only through the robot API.

Run as ``python -m server.cli.team``, it is ``python -m robots.sim.live`` that ends when its parent does: the
parent holds the other end of its standard input, which closes however the parent dies.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import urllib.request
import webbrowser
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Self

from server.cli.console import say

if TYPE_CHECKING:
    from server.settings import Settings

_LOOK_EVERY_S = 0.1
_PATIENCE_S = 5.0  # for the team to end by itself before it is killed


class SimulatedTeam:
    """Starts the team, which waits until mission control answers, and ends it on leaving.

    ``arguments`` are those of ``python -m robots.sim.live`` but ``--url``. Prints the address once it can be
    opened.
    """

    def __init__(self, settings: Settings, arguments: list[str], open_browser: bool) -> None:
        self._url = settings.address
        self._token = settings.robot_token or ""
        self._arguments = arguments
        self._open_browser = open_browser
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._look_after, name="simulated team")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._leaving.set()
        self._thread.join()

    def _look_after(self) -> None:
        command = [sys.executable, "-m", "server.cli.team", self._url, *self._arguments]
        # a session of its own: Ctrl-C reaches it through us, in order, and not twice
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            start_new_session=True,
            env=os.environ | {"WAYMARK_TOKEN": self._token},
        )
        try:
            if not self._server_opens():
                return
            print(f"Waymark is open at {self._url} (Ctrl-C ends it).", flush=True)
            if self._open_browser:
                webbrowser.open(self._url)
            while process.poll() is None:
                if self._leaving.wait(_LOOK_EVERY_S):
                    return
            if process.returncode == 0:
                say("The simulated mission is over; mission control stays open.")
            else:
                say("The simulated team has failed; mission control stays open.")
        finally:
            _end(process)

    def _server_opens(self) -> bool:
        while not self._leaving.wait(_LOOK_EVERY_S):
            if _answers(self._url):
                return True
        return False


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/api/v1/health", timeout=2.0) as reply:
            return bool(reply.status == 200)
    except OSError:  # not there yet, or an error status
        return False


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.stdin is not None:
        with suppress(OSError):
            process.stdin.close()
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _end_with_parent() -> None:
    with suppress(OSError):
        while sys.stdin.buffer.read(1024):
            pass
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_PATIENCE_S)
    os._exit(1)


def main(arguments: Sequence[str]) -> int:
    """Play a live mission on the server at the first argument until it is over or the parent is gone."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    from robots.sim.live import main as live  # takes a second, in which the server opens

    url, *rest = arguments
    while not _answers(url):
        time.sleep(_LOOK_EVERY_S)
    return live(["--url", url, *rest])


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is imported
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")
    sys.exit(main(sys.argv[1:]))
