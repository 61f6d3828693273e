"""The 3D scene of one mission: a viser server on its own loopback port, drawn from the mission's board."""

from __future__ import annotations

import asyncio
import contextlib
import io
import logging
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import viser
from viser.infra import StateSerializer

from web.viser.base_layer import BaseLayer
from web.viser.cameras import Cameras
from web.viser.colors import Palette
from web.viser.frontiers_layer import FrontiersLayer
from web.viser.map_layer import Cells, Grid, MapLayer
from web.viser.marks import Mark, Marks, mark_of
from web.viser.nodes_layer import NodesLayer
from web.viser.picking import pick
from web.viser.places import of_kind
from web.viser.robots_layer import RobotsLayer
from web.viser.seats import Seat, Wish, seat_key
from web.viser.tags_layer import TagsLayer
from web.viser.trails_layer import TrailsLayer
from web.viser.victims_layer import VictimsLayer
from web.viser.written_layer import Written, WrittenLayer, written_on

_DRAW_S = 0.1  # poses and victims
_SLOW_DRAW_S = 1.0  # map, trails and tags: large, and slow to change
_FAST = ("robot/", "victim/")
_REACH_PX = 14.0  # as far beside a thing a click may go: a finger is no pointer

_log = logging.getLogger(__name__)

Value = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Batch:
    """What to draw next: new values by board key (None: gone); tags with links, and grid, if they changed.

    ``nodes`` by tag id and ``alerts`` go with the tags; None where none of the three changed. ``wishes`` by
    viewer: what each page wants, and the mark on what it has selected. ``base``: the base map, if it changed.
    """

    values: dict[str, Value | None]
    tags: dict[str, Value] | None
    pairs: tuple[tuple[str, str], ...]
    grid: Grid | None
    nodes: dict[str, Value] | None = None
    alerts: tuple[Value, ...] = ()
    wishes: Mapping[int, tuple[Wish, Mark | None]] = field(default_factory=dict)
    written: Written | None = None
    base: tuple[Grid | None] | None = None


class MissionScene:
    """Keeps the latest value of every key and draws what changed, but only while somebody looks."""

    def __init__(
        self,
        theme: str = "dark",
        slow_draw_s: float = _SLOW_DRAW_S,
        seats: Mapping[str, Seat] | None = None,
    ) -> None:
        palette = Palette(theme)
        self._seats = {} if seats is None else seats
        self._drawing = asyncio.Lock()
        self._slow_draw_s = slow_draw_s
        with contextlib.redirect_stdout(io.StringIO()):  # its banner names a port that users must not go to
            self._server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        self.port = self._server.get_port()
        if not self.port:
            raise RuntimeError("The 3D view got no port on 127.0.0.1; free one and start again.")
        self._map = MapLayer(self._server, palette)
        self._base_layer = BaseLayer(self._server, palette)
        self._written = WrittenLayer(self._server, palette)
        self._robots = RobotsLayer(self._server, palette)
        self._trails = TrailsLayer(self._server, palette)
        self._frontiers = FrontiersLayer(self._server, palette)
        self._tags = TagsLayer(self._server, palette)
        self._nodes = NodesLayer(self._server, palette)
        self._drawn_tags: dict[str, Value] = {}
        self._victims = VictimsLayer(self._server, palette)
        self._cameras = Cameras(self._server)
        self._marks = Marks(self._server, palette, self._cameras)
        self._values: dict[str, Value] = {}
        self._changed: set[str] = set()
        self._grid: Grid | None = None
        self._base: tuple[Grid | None] | None = None  # what is not yet drawn
        self._has_map = False
        self._slow_drawn_s = -math.inf
        _light(self._server.scene, palette)
        # Sharing would open a tunnel to a public host; the proxy drops the request as well.
        self._server.gui.configure_theme(dark_mode=theme == "dark", show_logo=False, show_share_button=False)
        self._server.gui.set_panel_label("3D view")
        self._server.gui.main_panel.minimize()
        if seats is not None:
            self._server.scene.on_click()(self._click)

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
            if self._values.get(key) != value:
                self.put(key, value)

    async def show(self, values: dict[str, Value], grid: Grid | None) -> None:
        """Draw a state at once, whether due or not; ``grid`` where the map is another than before."""
        async with self._drawing:
            self.replace(values)
            if grid is not None:
                self._grid = grid
            self._slow_drawn_s = -math.inf
            await asyncio.to_thread(self.draw, self.take(0.0))

    def serializer(self) -> StateSerializer:
        """Return what records the scene from now on; see viser's ``get_scene_serializer``."""
        return self._server.get_scene_serializer()

    def look_from_above(self) -> None:
        """Let who opens the scene look at all of it, at a slant."""
        self._cameras.begin_over_all()

    def update_map(self, cells: Cells, origin_m: tuple[float, float], resolution_m: float) -> None:
        """Take the fused map: ``cells`` int8 (h, w), -1 unknown, 0..100; cell (0, 0) at ``origin_m``."""
        self._grid = Grid(cells, origin_m, resolution_m)

    def update_base(self, grid: Grid | None) -> None:
        """Take the base map, None where there is none."""
        self._base = (grid,)

    async def run(self) -> None:
        """Draw until cancelled: changes at most ten times a second, in a thread, nothing without a viewer."""
        while True:
            await asyncio.sleep(_DRAW_S)
            if not self._server.get_clients():
                continue
            try:
                async with self._drawing:
                    await asyncio.to_thread(self.draw, self.take(time.monotonic()))
            except Exception:  # the next change may well be drawable, and the plan does not need us
                _log.exception("The 3D scene could not be drawn.")

    def is_slow_due(self, now_s: float) -> bool:
        """Say whether map, trails and tags are drawn by the next ``take``."""
        return now_s - self._slow_drawn_s >= self._slow_draw_s

    def take(self, now_s: float) -> Batch:
        """Return what is due and count it as drawn. Called in the thread of ``put``, so they never cross."""
        is_slow_due = self.is_slow_due(now_s)
        changed = {key for key in self._changed if is_slow_due or key.startswith(_FAST)}
        self._changed -= changed
        tags, nodes, grid, written, base = None, None, None, None, None
        if is_slow_due:
            self._slow_drawn_s = now_s
            grid, self._grid = self._grid, None
            base, self._base = self._base, None
            written = written_on(self._values)  # notes and photos move with tags and victims
            if any(key == "links" or key.startswith("tag/") for key in changed):
                tags = self._of_kind("tag")
            if any(key.startswith(("tag/", "node/", "alert/")) for key in changed):
                nodes = self._of_kind("node")
        pairs = tuple(self._values.get("links", {}).get("pairs", ()))
        alerts = tuple(self._of_kind("alert").values())
        values = {key: self._values.get(key) for key in sorted(changed)}
        return Batch(values, tags, pairs, grid, nodes, alerts, self._wishes(), written, base)

    def _of_kind(self, kind: str) -> dict[str, Value]:
        return dict(of_kind(self._values, kind))

    def _wishes(self) -> dict[int, tuple[Wish, Mark | None]]:
        keys = {viewer: seat_key(self._server, viewer) or "" for viewer in self._server.get_clients()}
        wishes = {viewer: self._seats[key].wish for viewer, key in keys.items() if key in self._seats}
        return {viewer: (wish, mark_of(self._values, wish.selected)) for viewer, wish in wishes.items()}

    def _click(self, event: viser.SceneClickEvent) -> None:
        """Tell the page whose view was clicked what that means."""
        seat = self._seats.get(seat_key(self._server, event.client_id) or "")
        if seat is None:
            return
        camera = event.client.camera
        reach_rad = 2.0 * math.tan(camera.fov / 2.0) / max(camera.image_height, 1) * _REACH_PX
        named = pick(dict(self._values), event.ray_origin, event.ray_direction, reach_rad)
        if named is not None:
            seat.click(named)

    def draw(self, batch: Batch) -> None:
        """Bring the scene to the values of the batch."""
        for key, value in batch.values.items():
            kind, _, name = key.partition("/")
            if kind == "robot":
                self._robots.put(name, value)
                if value is not None:
                    self._cameras.see(value["x_m"], value["y_m"])
            elif kind == "victim":
                self._victims.put(name, value)
            elif kind == "trail":
                self._trails.put(name, value)
            elif kind == "frontiers":
                self._frontiers.put(name, value)
        if batch.tags is not None:
            self._drawn_tags = batch.tags
            self._tags.show(batch.tags, batch.pairs)
        if batch.nodes is not None:
            self._nodes.show(self._drawn_tags, batch.nodes, batch.alerts)
        if batch.written is not None:
            self._written.show(batch.written)
        if batch.grid is not None:
            self._has_map = True
            self._map.show(batch.grid)
            self._cameras.see_grid(batch.grid)
        if batch.base is not None:
            self._show_base(*batch.base)
        self._cameras.keep_in_view()
        self._marks.draw(batch.wishes)

    def _show_base(self, grid: Grid | None) -> None:
        self._base_layer.show(grid)
        if grid is not None and not self._has_map:
            self._cameras.see_grid(grid)

    def stop(self) -> None:
        """Close the port and every viewer's socket. Takes up to a second: call it in a thread."""
        with contextlib.redirect_stdout(io.StringIO()):
            self._server.stop()


def _light(scene: viser.SceneApi, palette: Palette) -> None:
    """Set the console's ground, and lights that leave the robots their colours; viser's own bleach them."""
    scene.set_up_direction("+z")
    scene.set_background_image(np.full((2, 2, 3), palette["unknown"], np.uint8), format="png")
    scene.configure_default_lights(enabled=False, cast_shadow=False)
    scene.configure_environment_map(None)
    scene.add_light_ambient("/lights/ambient", intensity=1.6)
    scene.add_light_directional("/lights/sun", position=(-2.0, -4.0, 6.0), intensity=1.8)
