"""The 3D scene of one mission: a viser server on a loopback port of its own, drawn from the mission's board."""

from __future__ import annotations

import asyncio
import contextlib
import io
import time
from math import hypot, tan
from typing import Any

import numpy as np
import viser

from web.viser.map_layer import Cells, Grid, MapLayer
from web.viser.robots_layer import RobotsLayer
from web.viser.tags_layer import TagsLayer
from web.viser.trails_layer import TrailsLayer
from web.viser.victims_layer import VictimsLayer

_DRAW_S = 0.1  # poses
_SLOW_DRAW_S = 1.0  # map, trails and tags: large, and slow to change
_SLANT = 0.6  # camera's distance aside per height
_MARGIN = 1.15  # of the view beyond the building

Value = dict[str, Any]


class MissionScene:
    """Keeps the latest value of every key and draws what changed, but only while somebody looks."""

    def __init__(self) -> None:
        with contextlib.redirect_stdout(io.StringIO()):  # its banner names a port that users must not go to
            self._server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        self.port = self._server.get_port()
        if not self.port:
            raise RuntimeError("The 3D view got no port on 127.0.0.1; free one and start again.")
        self._map = MapLayer(self._server)
        self._robots = RobotsLayer(self._server)
        self._trails = TrailsLayer(self._server)
        self._tags = TagsLayer(self._server)
        self._victims = VictimsLayer(self._server)
        self._values: dict[str, Value] = {}
        self._changed: set[str] = set()
        self._grid: Grid | None = None
        self._grid_changed = False
        self._slow_drawn_s = 0.0
        self._server.scene.set_up_direction("+z")
        self._server.scene.configure_default_lights(cast_shadow=False)
        # Sharing would open a tunnel to a public host; the proxy drops the request as well.
        self._server.gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        self._server.gui.set_panel_label("3D view")
        self._server.gui.main_panel.minimize()
        self._placed: dict[int, Any] = {}  # viewer -> where we put its camera; a viewer that moved it is left alone
        self._server.on_client_connect(self._welcome)

    def put(self, key: str, value: Value | None) -> None:
        """Take a change of the board; None when the key is gone."""
        if value is None:
            self._values.pop(key, None)
        else:
            self._values[key] = value
        self._changed.add(key)

    def replace(self, values: dict[str, Value]) -> None:
        """Take the whole board: keys that are not in it are gone."""
        for key in self._values.keys() - values.keys():
            self.put(key, None)
        for key, value in values.items():
            self.put(key, value)

    def update_map(self, cells: Cells, origin_m: tuple[float, float], resolution_m: float) -> None:
        """Take the fused map: ``cells`` int8 (h, w), -1 unknown, 0..100; cell (0, 0) at the corner ``origin_m``."""
        self._grid = Grid(cells, origin_m, resolution_m)
        self._grid_changed = True

    async def run(self) -> None:
        """Draw until cancelled: changes at most ten times a second, in a thread, and nothing without a viewer."""
        while True:
            await asyncio.sleep(_DRAW_S)
            if (self._changed or self._grid_changed) and self._server.get_clients():
                await asyncio.to_thread(self.draw, time.monotonic())

    def draw(self, now_s: float) -> None:
        """Bring the scene to the latest values; what is slow to draw only when it is due."""
        is_slow_due = now_s - self._slow_drawn_s >= _SLOW_DRAW_S
        changed = {key for key in self._changed if is_slow_due or key.startswith(("robot/", "victim/"))}
        self._changed -= changed
        for key in sorted(changed):
            kind, _, name = key.partition("/")
            if kind == "robot":
                self._robots.put(name, self._values.get(key))
            elif kind == "victim":
                self._victims.put(name, self._values.get(key))
            elif kind == "trail":
                self._trails.put(name, self._values.get(key))
        if not is_slow_due:
            return
        self._slow_drawn_s = now_s
        if any(key == "links" or key.startswith("tag/") for key in changed):
            tags = {key[4:]: value for key, value in self._values.items() if key.startswith("tag/")}
            self._tags.show(tags, self._values.get("links", {}).get("pairs", ()))
        if self._grid_changed and self._grid is not None:
            self._grid_changed = False
            self._map.show(self._grid)
            self._keep_in_view()

    def stop(self) -> None:
        """Close the port and every viewer's socket. Takes up to a second: call it in a thread."""
        with contextlib.redirect_stdout(io.StringIO()):
            self._server.stop()

    def _welcome(self, client: viser.ClientHandle) -> None:
        """Give a new viewer its camera and the two buttons that bring it back."""
        overview = client.gui.add_button("Overview", hint="Look at the whole building at a slant")
        top = client.gui.add_button("From above", hint="Look straight down")

        @overview.on_click
        def _(_event: object) -> None:
            self._look(client, _SLANT)

        @top.on_click
        def _(_event: object) -> None:
            self._look(client, 0.02)

        self._look(client, _SLANT)

    def _look(self, client: viser.ClientHandle, slant: float) -> None:
        """Put a viewer's camera over the middle of what is known; ``slant`` is its distance aside per height."""
        low, high = self._extent()
        centre, size_m = (low + high) / 2.0, np.maximum(high - low, 6.0)
        reach = tan(client.camera.fov / 2.0)  # half the view's height at distance 1
        distance_m = _MARGIN / 2.0 * max(size_m[1] / reach, size_m[0] / (reach * client.camera.aspect))
        direction = np.array((0.0, -slant, 1.0)) / hypot(slant, 1.0)
        position = np.append(centre, 0.0) + distance_m * direction
        with client.atomic():
            client.camera.up_direction = (0.0, 0.0, 1.0)
            client.camera.position = position
            client.camera.look_at = np.append(centre, 0.0)
        self._placed[client.client_id] = position

    def _keep_in_view(self) -> None:
        """Step back as the building grows, for every viewer who has not moved the camera since we placed it."""
        clients = self._server.get_clients()
        for gone in self._placed.keys() - clients.keys():
            del self._placed[gone]
        for client_id, client in clients.items():
            placed = self._placed.get(client_id)
            if placed is not None and np.allclose(client.camera.position, placed, atol=0.05):
                self._look(client, _SLANT)

    def _extent(self) -> tuple[Any, Any]:
        """Return the lower and upper corner, (2,) each in metres, of the map and the robots."""
        points = [
            (v["x_m"], v["y_m"]) for key, v in tuple(self._values.items()) if key.startswith(("robot/", "victim/"))
        ]
        if self._grid is not None:
            rows, columns = np.nonzero(self._grid.cells >= 0)
            origin, step = np.array(self._grid.origin_m), self._grid.resolution_m
            if len(rows):
                points.append(tuple(origin + step * np.array([columns.min(), rows.min()])))
                points.append(tuple(origin + step * np.array([columns.max(), rows.max()])))
        corners = np.array(points or [(0.0, 0.0)])
        return corners.min(axis=0), corners.max(axis=0)
