"""Twenty minutes of twelve robots, as a board shows them, for measuring what becomes of it afterwards."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from math import cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.team import TeamGrid

Value = dict[str, Any]

TICK_S = 0.5
_SIDE, _CELL_M = 1000, 0.1
_ROOM = 60  # cells from wall to wall
_SEES_M = 4.0
_PATH, _FRONTIERS = 40, 8


class PastMission:
    """Robots on smooth ways through rooms; ``grid``: what they have seen, ``values`` of the board by key."""

    def __init__(self, robots: int, seed: int = 1) -> None:
        self._random = np.random.default_rng(seed)
        self._names = [f"r{k + 1}" for k in range(robots)]
        self._phases = self._random.uniform(0.0, 2.0 * pi, (robots, 4))
        self._truth = _rooms()
        self._cells = np.full((_SIDE, _SIDE), -1, np.int8)
        self._trails: dict[str, list[list[float]]] = {name: [] for name in self._names}
        self._tags: dict[str, Value] = {}

    def grid(self, version: int) -> TeamGrid:
        """Return what has been seen so far."""
        return TeamGrid(self._cells, (-50.0, -50.0), _CELL_M, version)

    def ticks(self, minutes: float) -> Iterator[tuple[float, dict[str, Value]]]:
        """Yield the time since the beginning, and what the board is told, twice a second."""
        for k in range(round(60.0 * minutes / TICK_S) + 1):
            yield k * TICK_S, self._values(k)

    def _values(self, k: int) -> dict[str, Value]:
        now_s = k * TICK_S
        values: dict[str, Value] = {"mission": _mission(now_s)}
        for i, name in enumerate(self._names):
            x, y, yaw = self._pose(i, now_s)
            self._see(x, y)
            if k % 2 == 0:
                self._trails[name].append([round(x, 2), round(y, 2)])
            values[f"robot/{name}"] = self._robot(name, i, now_s, (x, y, yaw))
            if k % 4 == 0:
                values[f"frontiers/{name}"] = {"robot_id": name, "frontiers": self._frontiers(x, y)}
                values[f"trail/{name}"] = {"robot_id": name, "points_m": self._bent(self._trails[name])}
            if k % 40 == 0:
                tag_id = f"{name}-{k // 40:03d}"
                self._tags[tag_id] = _tag(tag_id, name, x, y)
                values[f"tag/{tag_id}"] = self._tags[tag_id]
        pairs = [list(pair) for pair in itertools.pairwise(self._tags)]
        values["links"] = {"pairs": pairs}
        return values

    def _pose(self, i: int, now_s: float) -> tuple[float, float, float]:
        a, b, c, d = self._phases[i]
        u, v = now_s / (70.0 + 9.0 * i), now_s / (95.0 + 5.0 * i)
        x = 30.0 * sin(u + a) + 14.0 * sin(2.1 * v + b)
        y = 30.0 * cos(v + c) + 14.0 * cos(1.7 * u + d)
        return x, y, (u + v) % (2.0 * pi) - pi

    def _see(self, x_m: float, y_m: float) -> None:
        row, column, reach = (
            int((y_m + 50.0) / _CELL_M),
            int((x_m + 50.0) / _CELL_M),
            int(_SEES_M / _CELL_M),
        )
        rows = slice(max(0, row - reach), min(_SIDE, row + reach))
        columns = slice(max(0, column - reach), min(_SIDE, column + reach))
        self._cells[rows, columns] = self._truth[rows, columns]

    def _robot(self, name: str, i: int, now_s: float, pose: tuple[float, float, float]) -> Value:
        x, y, yaw = pose
        ahead = [self._pose(i, now_s - now_s % 2.0 + 0.4 * n) for n in range(_PATH)]
        spread = [float(value) for value in self._random.uniform(0.01, 0.02, 4)]
        return {
            "robot_id": name,
            "x_m": round(x, 4),
            "y_m": round(y, 4),
            "yaw_rad": round(yaw, 4),
            "covariance": spread,
            "stamp_s": now_s,
            "heard_unix_s": now_s,
            "activity": "exploring",
            "reason": f"driving {int(now_s) % 17} m to see about {int(now_s) % 23} m² of new ground",
            "battery": 1.0 - now_s / 7200.0,
            "tags_left": 99,
            "agent": "server",
            "slam": "tag-graph",
            "methods": {},
            "stopped": False,
            "link": "live",
            "slipping": False,
            "located": True,
            "explored_m2": round(now_s / 3.0, 2),
            "distance_m": round(0.4 * now_s, 2),
            "goal_m": [round(v, 3) for v in ahead[-1][:2]],
            "path_m": [[round(v, 3) for v in place[:2]] for place in ahead],
            "speed_mps": 0.4,
        }

    def _frontiers(self, x: float, y: float) -> list[Value]:
        return [
            {
                "x_m": round(x + float(dx), 2),
                "y_m": round(y + float(dy), 2),
                "length_m": 1.5,
                "worth_m": 3.0,
                "chosen": n == 0,
            }
            for n, (dx, dy) in enumerate(self._random.uniform(-9.0, 9.0, (_FRONTIERS, 2)))
        ]

    def _bent(self, trail: list[list[float]]) -> list[list[float]]:
        """Return the trail as a solution of the graph leaves it: now and then all of it has moved."""
        if self._random.random() < 0.2:
            dx, dy = self._random.uniform(-0.05, 0.05, 2)
            trail[:] = [[round(x + dx, 2), round(y + dy, 2)] for x, y in trail]
        return [list(point) for point in trail]


def _mission(now_s: float) -> Value:
    words = {"mission_id": "bench", "name": "Bench", "state": "running", "created_unix_s": 0.0}
    return {**words, "clock_s": now_s, "stopped_all": False}


def _rooms() -> NDArray[np.int8]:
    cells = np.zeros((_SIDE, _SIDE), np.int8)
    rows, columns = np.indices(cells.shape)
    is_wall = ((rows % _ROOM < 2) & (columns % _ROOM > 12)) | ((columns % _ROOM < 2) & (rows % _ROOM > 12))
    cells[is_wall] = 100
    return cells


def _tag(tag_id: str, robot: str, x: float, y: float) -> Value:
    place = {"x_m": round(x, 4), "y_m": round(y, 4), "covariance": [0.01, 0.0, 0.01]}
    return {"tag_id": tag_id, **place, "sightings": 1, "robots": [robot], "state": "sound", "notice": ""}
