"""The mark on what somebody has selected: in that viewer's scene alone, and their camera with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import viser

from web.viser.cameras import Cameras
from web.viser.colors import Palette
from web.viser.picking import ALERT_M, SOLIDS, Named
from web.viser.places import Corners, Place, Values, corners_of, of_kind, place_of
from web.viser.seats import Wish
from web.viser.shapes import outline, spike, unit_ring

_RING = unit_ring()
_POINTER = spike(0.15, 0.4)
_ABOVE_FLOOR_M = 0.06
_RADII_M = {"robot": 0.95, "victim": 0.6, "tag": 0.4, "note": 0.5}
_CLEAR_M = {"robot": 1.6, "victim": 3.2, "tag": 1.5, "note": 2.6}  # over names, and low walls


class Mark(NamedTuple):
    """What is marked: its looks, and where it is. ``label`` where the scene has no name at it."""

    kind: str
    label: str
    corners_m: Corners
    has_pin: bool
    place: Place


@dataclass(slots=True)
class _Drawn:
    wish: Wish
    mark: Mark | None
    frame: Any


def mark_of(values: Values, selected: Named | None) -> Mark | None:
    """Return the mark on what is selected, None where that is not in the scene."""
    place = None if selected is None else place_of(values, *selected)
    if selected is None or place is None:
        return None
    kind, thing_id = selected
    has_pin = kind == "tag" and any(alert.get("tag_id") == thing_id for _, alert in of_kind(values, "alert"))
    corners = corners_of(values[f"sector/{thing_id}"]) if kind == "sector" else ()
    label = thing_id if kind == "tag" and not has_pin else ""
    return Mark(kind, label, corners, has_pin, place)


class Marks:
    """Draws for each viewer what their own page has selected."""

    def __init__(self, server: viser.ViserServer, palette: Palette, cameras: Cameras):
        self._server = server
        self._palette = palette
        self._cameras = cameras
        self._drawn: dict[int, _Drawn] = {}

    def draw(self, wanted: Mapping[int, tuple[Wish, Mark | None]]) -> None:
        """Bring every viewer's mark and camera to what is wanted, by viewer."""
        clients = self._server.get_clients()
        for gone in self._drawn.keys() - clients.keys():
            del self._drawn[gone]
        for client_id, (wish, mark) in wanted.items():
            client = clients.get(client_id)
            if client is not None:
                self._draw(client, wish, mark)

    def _draw(self, client: viser.ClientHandle, wish: Wish, mark: Mark | None) -> None:
        drawn = self._drawn.setdefault(client.client_id, _Drawn(Wish(), None, None))
        if mark != drawn.mark:
            self._put(client, drawn, mark)
        if mark is not None and wish.centred != drawn.wish.centred:
            self._cameras.centre(client, mark.place)
        elif mark is not None and wish.follows:
            self._cameras.follow(client, mark.place, is_new=not drawn.wish.follows)
        drawn.wish, drawn.mark = wish, mark

    def _put(self, client: viser.ClientHandle, drawn: _Drawn, mark: Mark | None) -> None:
        if mark is not None and drawn.mark is not None and mark[:-1] == drawn.mark[:-1]:
            drawn.frame.position = (*mark.place, 0.0)
            return
        with client.atomic():
            if drawn.frame is not None:
                drawn.frame.remove()
            drawn.frame = None if mark is None else self._add(client.scene, mark)

    def _add(self, scene: viser.SceneApi, mark: Mark) -> Any:
        frame = scene.add_frame("/selected", show_axes=False, position=(*mark.place, 0.0))
        color = self._palette["ring"]
        if mark.kind == "sector":
            corners = np.array(mark.corners_m) - mark.place
            scene.add_line_segments(
                "/selected/outline",
                outline(corners, _ABOVE_FLOOR_M),
                color,
                thickness=5.0,
                thickness_units="screen",
            )
            return frame
        radius = _RADII_M[mark.kind]
        clear = ALERT_M + 1.2 if mark.has_pin else _CLEAR_M[mark.kind]
        plain = {"color": color, "side": "double", "cast_shadow": False, "receive_shadow": False}
        scene.add_mesh_simple(
            "/selected/ring",
            *_RING,
            scale=(radius, radius, 1.0),
            position=(0.0, 0.0, _ABOVE_FLOOR_M),
            **plain,
        )
        scene.add_mesh_simple(
            "/selected/pointer", *_POINTER, flat_shading=True, position=(0.0, 0.0, clear), **plain
        )
        if mark.label:
            top = SOLIDS[mark.kind].height_m + 0.35
            scene.add_label("/selected/label", mark.label, position=(0.0, 0.0, top), anchor="bottom-center")
        return frame
