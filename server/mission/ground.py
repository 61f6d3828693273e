"""Pictures of the ground that are made when somebody looks at them, every two seconds at most."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from db.store import Store
from robots.exploration.settings import SafeGroundConfig
from server.errors import ApiError
from server.ground_layers import CLEARED, SAFE, came_late, coverage, in_world, own_map
from server.map_image import MapImage, draw, draw_classes
from server.mission.roster import Roster
from server.mission.shared_map import SharedMap

_KEPT_S = 2.0
_NONE = np.zeros((0, 3))
_NO_MAP = ApiError(404, "no_map", "There is no such map yet; it comes with the first scans.")

_T = TypeVar("_T")


class Ground:
    """Coverage, robots' own maps, and where robots were heard."""

    def __init__(self, store: Store, roster: Roster, shared_map: SharedMap) -> None:
        self._store = store
        self._roster = roster
        self._shared_map = shared_map
        self._made: dict[str, tuple[float, Any]] = {}
        self._making = asyncio.Lock()

    async def coverage(self) -> tuple[MapImage, dict[str, float]]:
        """Return a picture of how well the ground was looked at, and the areas in square metres."""
        return await self._kept("coverage", self._coverage)

    async def own_map(self, robot_id: str) -> MapImage:
        """Return the map that one robot's scans make."""
        self._roster.get(robot_id)
        return await self._kept(f"robot/{robot_id}", lambda: self._own_map(robot_id))

    async def contact(self) -> list[dict[str, Any]]:
        """Return where each robot was, and whether it was heard there or told of it later."""
        return await self._kept("contact", self._contact)

    async def _kept(self, name: str, make: Callable[[], Awaitable[_T]]) -> _T:
        async with self._making:
            made_s, value = self._made.get(name, (-_KEPT_S, None))
            if value is None or time.monotonic() - made_s > _KEPT_S:
                value = await make()
                self._made[name] = time.monotonic(), value
            kept: _T = value  # a name stands for one kind of thing
            return kept

    def _way(self, robot_id: str) -> tuple[np.ndarray, np.ndarray]:
        """Seqs (n,) and world poses (n, 3) of a robot's way."""
        anchors = self._roster.get(robot_id).anchors
        way = self._shared_map.way(robot_id, 2**62)
        if anchors is None:
            return np.zeros(0), _NONE
        way = way[way[:, 2] < len(anchors)]
        way = way[np.argsort(way[:, 0])]
        return way[:, 0], in_world(anchors, way)

    async def _coverage(self) -> tuple[MapImage, dict[str, float]]:
        grid = self._shared_map.grid
        if grid is None:
            raise _NO_MAP
        ways = [self._way(robot_id)[1] for robot_id in self._roster.robots]
        classes, cell_m = await asyncio.to_thread(coverage, grid, ways, SafeGroundConfig().safe_m)
        image = draw_classes(classes, grid.version, grid.origin_m, cell_m)
        areas = {
            "free_m2": float((classes > 0).sum()) * cell_m**2,
            "safe_m2": float((classes >= SAFE).sum()) * cell_m**2,
            "cleared_m2": float((classes == CLEARED).sum()) * cell_m**2,
        }
        return _with_own_version(image), areas

    async def _own_map(self, robot_id: str) -> MapImage:
        anchors = self._roster.get(robot_id).anchors
        submaps = self._shared_map.submaps(robot_id)
        if anchors is None or not submaps:
            raise _NO_MAP
        grid = await asyncio.to_thread(own_map, submaps, anchors)
        if grid is None:
            raise _NO_MAP
        return _with_own_version(await asyncio.to_thread(draw, grid))

    async def _contact(self) -> list[dict[str, Any]]:
        found = []
        for robot_id in self._roster.robots:
            seqs, way = self._way(robot_id)
            log = await self._store.log.arrivals(self._roster.record.mission_id, robot_id)
            late = came_late(log[:, 1], log[:, 2])
            at = np.minimum(np.searchsorted(log[:, 0], seqs), max(0, len(log) - 1))
            heard = ~late[at] if len(log) else np.zeros(len(seqs), bool)
            points = [(round(float(x), 2), round(float(y), 2)) for x, y, _ in way]
            found.append({"robot_id": robot_id, "points_m": points, "heard": heard.tolist()})
        return found


def _with_own_version(image: MapImage) -> MapImage:
    """Number a picture by what is in it: the browser fetches it anew only when that has changed."""
    return replace(image, version=int(image.etag.strip('"')[:12], 16))
