"""`waymark serve` and `waymark demo`: real processes, which leave nothing behind."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from server.cli.main import run

ROOT = Path(__file__).parents[3]


class Process:
    """The command in a process of its own, with all that it starts."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.errors = folder / "stderr"
        with self.errors.open("w") as errors:
            self.popen = subprocess.Popen(
                [sys.executable, "-m", "server.cli.main", *arguments],
                cwd=ROOT,
                env={**os.environ, "TMPDIR": str(folder)},
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                start_new_session=True,
            )
        self.family: set[psutil.Process] = set()

    def first_line(self) -> str:
        assert self.popen.stdout is not None
        line = self.popen.stdout.readline()
        assert line, self.errors.read_text()
        return line

    def until(self, condition: Callable[[], object], timeout_s: float = 60.0) -> None:
        end = time.monotonic() + timeout_s
        while True:
            with suppress(OSError):
                if condition():
                    return
            assert time.monotonic() < end, self.errors.read_text()
            assert self.popen.poll() is None, self.errors.read_text()
            time.sleep(0.1)

    def end(self, by: signal.Signals) -> int:
        self.family = set(psutil.Process(self.popen.pid).children(recursive=True))
        self.popen.send_signal(by)
        return self.popen.wait(20)

    def left_behind(self) -> list[psutil.Process]:
        _, alive = psutil.wait_procs(self.family, timeout=10)
        return alive

    def close(self) -> None:
        with suppress(psutil.NoSuchProcess):
            for process in psutil.Process(self.popen.pid).children(recursive=True):
                with suppress(psutil.NoSuchProcess):
                    process.kill()
        if self.popen.poll() is None:
            self.popen.kill()
            self.popen.wait()
        for process in self.left_behind():
            process.kill()
        if self.popen.stdout is not None:
            self.popen.stdout.close()


@pytest.fixture
def start(tmp_path) -> Iterator[Callable[..., Process]]:
    started: list[Process] = []

    def starter(*arguments: str) -> Process:
        started.append(Process(tmp_path, *arguments))
        return started[-1]

    yield starter
    for process in started:
        process.close()


def get(url: str) -> dict:
    with urllib.request.urlopen(url, timeout=5) as reply:
        return json.loads(reply.read())


@pytest.mark.slow
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_demo_opens_a_mission_and_leaves_nothing_behind(start, tmp_path, by):
    process = start("demo", "--port", "0", "--robots", "2", "--map", "office:60", "--minutes", "5")
    url = process.first_line().split()[4]
    process.until(lambda: get(f"{url}/api/v1/missions/demo/map")["width"] > 0)
    robots = get(f"{url}/api/v1/missions/demo/robots")["robots"]
    assert len(robots) == 2
    process.end(by)
    assert process.left_behind() == []
    if by is not signal.SIGKILL:
        assert not list(tmp_path.glob("waymark-demo-*"))
        assert "Traceback" not in process.errors.read_text()


def test_a_busy_port_is_one_sentence(capsys, tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        for command in ("serve", "demo"):
            assert run([command, "--port", port, "--data", str(tmp_path)]) == 1
            shown = capsys.readouterr()
            assert f"port {port}" in shown.err
            assert "--port" in shown.err
            assert shown.err.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["serve", "--port", "70000"], "setting port (WAYMARK_PORT)"),
        (["serve", "--port", "0", "--host", "203.0.113.1"], "--port"),
        (["demo", "--port", "0", "--robots", "0"], "robots 0 is out of range"),
        (["demo", "--port", "0", "--map", "absent.yaml"], "absent.yaml"),
        (["demo", "--port", "0", "--speed", "nan"], "--speed has to be a finite number"),
        (["serve", "--port", "0", "--data", "FILE"], "FILE"),
        (["serve", "--port", "0", "--database", "FILE"], "is not a Waymark database"),
    ],
)
def test_what_cannot_be_served_is_one_sentence(capsys, tmp_path, arguments, words):
    file = tmp_path / "FILE"
    file.write_text("not a folder, and not a database either, whatever anyone says\n" * 40)
    assert run([str(file) if word == "FILE" else word for word in arguments]) == 1
    shown = capsys.readouterr()
    assert words in shown.err
    assert shown.err.count("\n") == 1
    assert "Traceback" not in shown.err
