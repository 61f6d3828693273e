"""The real application with a board that moves as twelve robots at full speed move it, without robots.

``python -m server.benchmarks.console_server PORT FOLDER``: so the web part is measured without agents.
"""

from __future__ import annotations

import asyncio
import contextlib
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import uvicorn
from fastapi import FastAPI

from robots.team import TeamGrid
from server.app import create_app
from server.map_image import draw
from server.mission.mission import Mission
from server.settings import Settings
from server.sharing import map_value

MISSION = "bench"
ROBOTS, POSES_HZ, MAPS_HZ, SIDE = 12, 10.0, 2.0, 1000  # cells of 5 cm


def rooms(known: float) -> np.ndarray:
    """Return a plan of rooms of 5 m with doors, known up to a share of its columns."""
    cells = np.zeros((SIDE, SIDE), np.int8)
    cells[::100] = cells[:, ::100] = 100
    for k in range(50, SIDE, 100):
        cells[::100, k - 10 : k + 10] = cells[k - 10 : k + 10, ::100] = 0
    cells[:, int(known * SIDE) :] = -1
    return cells


def robot(k: int, now_s: float) -> dict[str, Any]:
    """Return a robot as the board has it; its stamp is when it was published."""
    angle = 0.2 * now_s + k
    x_m, y_m = 25.0 + (2.0 + k) * cos(angle), 25.0 + (2.0 + k) * sin(angle)
    return {
        "robot_id": f"r{k}", "x_m": round(x_m, 4), "y_m": round(y_m, 4), "yaw_rad": round(angle % 6.28, 4),
        "covariance": [0.01, 0.001, 0.02, 0.001], "stamp_s": now_s, "heard_unix_s": now_s,
        "activity": "exploring",
        "reason": "driving 4 m to see about 12 m² that nobody has told of", "battery": 0.8, "tags_left": 80,
        "agent": "server", "slam": "tag-graph", "methods": {"explore": "waymark", "coordinate": "none"},
        "stopped": False, "link": "live", "slipping": False, "located": True, "explored_m2": 120.0,
        "distance_m": round(now_s % 1e4, 2), "goal_m": [x_m + 3.0, y_m],
        "path_m": [[x_m + 1.0, y_m], [x_m + 3.0, y_m]],
        "speed_mps": 0.4,
    }  # fmt: skip


async def _move(mission: Mission) -> None:
    async def poses() -> None:
        while True:
            for k in range(1, ROBOTS + 1):  # one after the other, as posts come
                mission.board.publish({f"robot/r{k}": robot(k, time.time())})
                await asyncio.sleep(1.0 / (POSES_HZ * ROBOTS))

    async def maps() -> None:
        version = 0
        while True:
            version += 1
            grid = TeamGrid(rooms(0.3 + 0.7 * (version % 120) / 120), (0.0, 0.0), 0.05, version)
            mission.shared_map.image = await asyncio.to_thread(draw, grid)
            mission.board.publish({"map": map_value(MISSION, mission.shared_map.image)})
            await asyncio.sleep(1.0 / MAPS_HZ)

    await asyncio.gather(poses(), maps())


def _serve(port: int, folder: Path) -> None:
    app = create_app(Settings.model_validate({"data_dir": folder, "login": "off"}))
    inner = app.router.lifespan_context

    @asynccontextmanager
    async def lifespan(served: FastAPI) -> AsyncIterator[None]:
        async with inner(served):
            mission = await served.state.missions.open("Bench", MISSION)
            moving = asyncio.create_task(_move(mission))
            yield
            moving.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await moving

    app.router.lifespan_context = lifespan
    # as ``server.serve`` has it
    uvicorn.run(
        app,
        port=port,
        log_level="error",
        access_log=False,
        ws_per_message_deflate=False,
        ws_ping_interval=10.0,
        ws_ping_timeout=20.0,
    )


if __name__ == "__main__":
    _serve(int(sys.argv[1]), Path(sys.argv[2]))
