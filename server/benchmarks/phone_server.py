"""The real application with a large mission, without robots: a lattice of tags, and trails past all of them.

``python -m server.benchmarks.phone_server PORT FOLDER TAGS``
"""

from __future__ import annotations

import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from math import ceil, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import uvicorn
from fastapi import FastAPI

from server.app import create_app
from server.settings import Settings

MISSION = "large"
_APART_M = 3.0


def board(tags: int, rng: np.random.Generator) -> dict[str, dict[str, Any]]:
    """Return the board's values of so many tags and of the trails that lead past all of them."""
    side = ceil(sqrt(tags))
    near = _APART_M * np.stack(np.divmod(np.arange(tags), side), 1) + rng.normal(0.0, 0.3, (tags, 2))
    values: dict[str, dict[str, Any]] = {}
    for k, (x_m, y_m) in enumerate(near.round(4).tolist()):
        values[f"tag/T{k}"] = {
            "tag_id": f"T{k}", "x_m": x_m, "y_m": y_m, "covariance": [0.01, 0.0, 0.01],
            "state": "sound", "notice": "",
        }  # fmt: skip
    rows = [near[k * side : (k + 1) * side] for k in range(side)]
    columns = [near[k::side] for k in range(side)]
    for k, line in enumerate([*rows, *columns]):
        points = np.vstack([line, line[-1:]])  # a line of one tag has an end, too
        values[f"trail/r{k}"] = {"robot_id": f"r{k}", "points_m": points.round(2).tolist()}
    return values


def _serve(port: int, folder: Path, tags: int) -> None:
    app = create_app(Settings.model_validate({"data_dir": folder, "login": "off"}))
    inner = app.router.lifespan_context

    @asynccontextmanager
    async def lifespan(served: FastAPI) -> AsyncIterator[None]:
        async with inner(served):
            mission = await served.state.missions.open("Large", MISSION)
            mission.board.publish(board(tags, np.random.default_rng(1)))
            yield

    app.router.lifespan_context = lifespan
    uvicorn.run(app, port=port, log_level="error", access_log=False)


if __name__ == "__main__":
    _serve(int(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
