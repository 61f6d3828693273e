"""From a robot's POST to a dashboard's socket: twelve simulated robots, five dashboards, one server."""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Sequence
from multiprocessing.queues import Queue
from typing import Any

import numpy as np
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from robots.client import Json, RobotClient
from robots.sim.live import play
from robots.sim.scenario import ScenarioConfig

_MISSION = "bench"
_WARM_S = 5.0  # at the start every process is loading at once
_Post = tuple[str, float, float]  # robot, stamp of its newest observation, when it was sent


def measure(robots: int = 12, dashboards: int = 5, seconds: float = 60.0) -> dict[str, Any]:
    """Return quantiles in milliseconds of the way from the start of a POST to every dashboard's socket."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    url = f"http://127.0.0.1:{port}"
    with tempfile.TemporaryDirectory(prefix="waymark-bench-") as folder:
        arguments = ["serve", "--port", str(port), "--data", folder, "--login", "off"]
        server = subprocess.Popen(
            [sys.executable, "-m", "server.cli.main", *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            _wait_for(url)
            context = multiprocessing.get_context("spawn")
            posts: Queue[list[_Post]] = context.Queue()
            team = context.Process(target=_drive, args=(url, robots, seconds, posts), daemon=True)
            team.start()
            seen = asyncio.run(_watch(f"ws://127.0.0.1:{port}", dashboards, seconds + _WARM_S))
            sent = posts.get(timeout=seconds + 60.0)
            team.join()
        finally:
            server.terminate()
            server.wait()
    return _quantiles(sent, seen, robots, dashboards)


class _TimedClient(RobotClient):
    """A client that notes when it begins to send."""

    sent: list[_Post] = []  # noqa: RUF012 - shared on purpose: one list for the whole team

    def post(self, observations: Sequence[Json] = (), onboard: Sequence[Json] | None = None) -> Json:
        """Send observations."""
        if observations:
            self.sent.append((self._robot_id, observations[-1]["stamp_s"], time.time()))
        return super().post(observations, onboard)


def _drive(url: str, robots: int, seconds: float, posts: Queue[list[_Post]]) -> None:
    config = ScenarioConfig(map="office:600", robots=robots, minutes=seconds / 60.0, seed=1)
    play(config, url, _MISSION, speed=1.0, client_type=_TimedClient)
    posts.put(_TimedClient.sent)


async def _watch(url: str, dashboards: int, seconds: float) -> list[dict[tuple[str, float], float]]:
    return list(await asyncio.gather(*(_dashboard(url, seconds) for _ in range(dashboards))))


async def _dashboard(url: str, seconds: float) -> dict[tuple[str, float], float]:
    """Return when each robot's stamp arrived: {(robot, stamp): unix time}."""
    arrivals: dict[tuple[str, float], float] = {}
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        try:
            async with connect(f"{url}/api/v1/missions/{_MISSION}/stream", max_size=None) as stream:
                while time.monotonic() < until:
                    message = json.loads(await asyncio.wait_for(stream.recv(), 5.0))
                    now = time.time()
                    for key, value in {**message.get("state", {}), **message.get("set", {})}.items():
                        if key.startswith("robot/"):
                            arrivals.setdefault((value["robot_id"], value["stamp_s"]), now)
        except (OSError, TimeoutError, WebSocketException):
            await asyncio.sleep(0.2)  # the mission is not there yet
    return arrivals


def _quantiles(
    sent: list[_Post], seen: list[dict[tuple[str, float], float]], robots: int, dashboards: int
) -> dict[str, Any]:
    """A pose that was overtaken by a newer one has arrived when the newer one did: latest state wins."""
    begin = sent[0][2] + _WARM_S
    delays: list[float] = []
    for arrivals in seen:
        for robot_id in {name for name, _, _ in sent}:
            stamps = sorted((stamp, at) for (name, stamp), at in arrivals.items() if name == robot_id)
            if not stamps:
                continue
            stamp_list = np.array([stamp for stamp, _ in stamps])
            at_list = np.array([at for _, at in stamps])
            for name, stamp, at in sent:
                k = int(np.searchsorted(stamp_list, stamp))
                if name == robot_id and at > begin and k < len(at_list):
                    delays.append((float(at_list[k]) - at) * 1e3)
    return {
        "robots": robots,
        "dashboards": dashboards,
        "poses_per_s": len({(name, stamp) for name, stamp, at in sent if at > begin})
        / max(1e-9, sent[-1][2] - begin),
        "pose_to_socket_ms_p50": float(np.median(delays)),
        "pose_to_socket_ms_p95": float(np.percentile(delays, 95)),
        "pose_to_socket_ms_p99": float(np.percentile(delays, 99)),
        "samples": len(delays),
    }


def _wait_for(url: str) -> None:
    for _ in range(600):
        try:
            with urllib.request.urlopen(f"{url}/api/v1/health", timeout=2.0) as reply:
                if reply.status == 200:
                    return
        except OSError:
            time.sleep(0.1)
    raise TimeoutError("the server did not start within a minute")
