"""The console under load: twelve robots at 10 Hz, a map of a million cells at 2 Hz, twenty who watch."""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import os
import socket
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from subprocess import DEVNULL, Popen
from sys import executable
from typing import Any

import httpx
import numpy as np
from websockets.asyncio.client import connect

from robots.sim.live import play
from robots.sim.scenario import ScenarioConfig
from server.benchmarks import changes
from server.benchmarks.browser import chromium, server_process, wait_for
from server.benchmarks.console_server import MISSION

WATCHERS = 20
_STOPPED = 4  # real robots, whose physics and agents share the machine with all that is measured
_HELD_MS = 600
_DRAWN = "() => document.querySelector('canvas.building')?.width > 0"
_ALL_LIVE = "(count) => document.querySelectorAll('.robot-card[data-link=live]').length === count"
_PRESS = """async (held_ms) => {
  const press = (type) => new PointerEvent(type, { button: 0, bubbles: true });
  const button = document.querySelector(".stop-all");
  button.dispatchEvent(press("pointerdown"));
  const fired = performance.now() + held_ms;
  const waits = () => document.querySelector(".robot-card:not([data-stop=braking], [data-stop=stopped])");
  while (performance.now() < fired || waits()) await new Promise(requestAnimationFrame);
  return performance.now() - fired;
}"""


@contextmanager
def _server() -> Iterator[tuple[str, int]]:
    """The address and the process of a server whose board moves."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory(prefix="waymark-bench-") as folder:
        arguments = [executable, "-m", "server.benchmarks.console_server", str(port), folder]
        process = Popen(arguments, stdout=DEVNULL, stderr=DEVNULL)
        try:
            wait_for(f"http://127.0.0.1:{port}")
            yield f"http://127.0.0.1:{port}", process.pid
        finally:
            process.terminate()
            process.wait()


def measure(seconds: float = 20.0) -> dict[str, Any]:
    """Return delays in milliseconds, shares of a core in per cent, seconds until a stalled one is dropped.

    Raises:
        CannotMeasureError: there is no browser here.
    """
    with _server() as (home, pid):
        time.sleep(3.0)
        alone = _share(pid, lambda: time.sleep(seconds / 2))
        delays: list[float] = []
        watched = _share(pid, lambda: delays.extend(asyncio.run(_watch(home, seconds))))
        found: dict[str, Any] = {
            "load of the machine": os.getloadavg()[0],
            "watchers": WATCHERS,
            "pose to socket p50, ms": float(np.percentile(delays, 50)),
            "pose to socket p95, ms": float(np.percentile(delays, 95)),
            "poses received": len(delays),
            "share of a core with nobody, %": 100.0 * alone,
            "share of a core with all, %": 100.0 * watched,
            "a stalled watcher is dropped after, s": asyncio.run(_stalled(home)),
            **asyncio.run(changes.measure(home, MISSION, WATCHERS)),
        }
        with chromium() as browser:
            found["first map on screen, ms"] = _first_map(browser, home)
            found[f"STOP of {_STOPPED} robots on screen, ms"] = _stop(browser)
    return {name: round(value, 1) for name, value in found.items()}


def _drive(home: str) -> None:
    play(ScenarioConfig(map="office:600", robots=_STOPPED, minutes=4.0, seed=1), home, MISSION, speed=1.0)


def _stop(browser: Any) -> float:
    """Return the time from STOP ALL until the cards of all driving robots say they heard it, in ms."""
    with server_process() as home:
        team = multiprocessing.get_context("spawn").Process(target=_drive, args=(home,), daemon=True)
        team.start()
        try:
            page = browser.new_page(viewport={"width": 1366, "height": 768})
            page.goto(f"{home}/console")
            page.wait_for_function(_ALL_LIVE, arg=_STOPPED, timeout=120_000)
            took = page.evaluate(_PRESS, _HELD_MS)
            page.close()
        finally:
            team.kill()
            team.join()
    return float(took)


def _share(pid: int, act: Any) -> float:
    """Return the share of a core that a process takes while something is done: user and system time."""
    ticks, began = _ticks(pid), time.monotonic()
    act()
    return (_ticks(pid) - ticks) / os.sysconf("SC_CLK_TCK") / (time.monotonic() - began)


def _ticks(pid: int) -> int:
    with open(f"/proc/{pid}/stat") as stat:
        return sum(map(int, stat.read().rsplit(")", 1)[1].split()[11:13]))


async def _watch(home: str, seconds: float) -> list[float]:
    found = await asyncio.gather(*(_watcher(home, seconds) for _ in range(WATCHERS)))
    return [delay for each in found for delay in each]


async def _watcher(home: str, seconds: float) -> list[float]:
    """Do as the page does: read the stream, fetch each picture of the map; return the poses' delays in ms."""
    delays: list[float] = []
    until = time.monotonic() + seconds
    fetching: asyncio.Task[Any] | None = None
    async with (
        httpx.AsyncClient(base_url=home) as client,
        connect(f"{home.replace('http', 'ws')}/api/v1/missions/{MISSION}/stream", max_size=None) as stream,
    ):
        await stream.recv()  # what was there before
        while time.monotonic() < until:
            message = json.loads(await stream.recv())
            now = time.time()
            values = message["set"]
            delays += [1e3 * (now - v["stamp_s"]) for key, v in values.items() if key.startswith("robot/")]
            if "map" in values and (fetching is None or fetching.done()):
                fetching = asyncio.create_task(client.get(values["map"]["png"]))
        if fetching is not None:
            await fetching
    return delays


async def _stalled(home: str) -> float:
    """Return after how many seconds somebody who reads nothing is not counted as watching any more."""
    port = int(home.rsplit(":", 1)[1])
    stalled = socket.socket()
    stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    stalled.connect(("127.0.0.1", port))
    stalled.sendall(
        f"GET /api/v1/missions/{MISSION}/stream HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
    )
    address = f"{home.replace('http', 'ws')}/api/v1/missions/{MISSION}/stream"
    pages, began = 0, time.monotonic()
    with suppress(TimeoutError):
        async with asyncio.timeout(90.0), connect(address, max_size=None) as stream:
            while True:
                message = json.loads(await stream.recv())
                person = (message.get("state") or message.get("set", {})).get("person/operator")
                if person and pages == 2 and person["pages"] == 1:
                    break
                pages = person["pages"] if person else pages
    stalled.close()
    return time.monotonic() - began


def _first_map(browser: Any, home: str) -> float:
    """Return the time from opening the console to its first map, in ms, with warm caches of the server."""
    took = 0.0
    for _ in range(2):
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        page.goto(f"{home}/console?mission={MISSION}", wait_until="commit")
        page.wait_for_function(_DRAWN)
        took = page.evaluate("performance.now()")
        page.close()
    return float(took)
