"""Active nodes as masts, and the alerts about them as tall pins with words that show over the walls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, pi, sin
from typing import Any

import numpy as np
import viser

from web.viser.colors import Palette
from web.viser.shapes import prism, upright

_MAST = prism([(0.03 * cos(i * pi / 3), 0.03 * sin(i * pi / 3)) for i in range(6)], 0.5)
_PIN_M = 1.8

Value = dict[str, Any]


_WORDS = {"hot": "hot", "tilted": "knocked over", "pressure": "pressure", "tag": "moved?", "mayday": "MAYDAY"}


class NodesLayer:
    """Draws all nodes whose place is known, at once: they change seldom."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._server = server
        self._pins: dict[str, str] = {}  # tag -> name in the scene

    def show(self, tags: Mapping[str, Value], nodes: Mapping[str, Value], alerts: Sequence[Value]) -> None:
        """Replace nodes and alerts by those of the board; ``tags`` by tag id tell where they are."""
        scene = self._server.scene
        masts = [(tags[tag_id]["x_m"], tags[tag_id]["y_m"], 0.0) for tag_id in nodes if tag_id in tags]
        # one pin a node, of its most urgent alert
        urgent = sorted(alerts, key=lambda a: (a["acknowledged_unix_s"] is None, a["severity"] == "alarm"))
        placed = {alert["tag_id"]: alert for alert in urgent if alert["tag_id"] in tags}
        with self._server.atomic():
            if masts:
                scene.add_batched_meshes_simple(
                    "/nodes/masts",
                    *_MAST,
                    batched_wxyzs=upright(len(masts)),
                    batched_positions=np.array(masts, np.float32),
                    batched_colors=self._palette["tag"],
                    lod="off",
                    flat_shading=True,
                    cast_shadow=False,
                    receive_shadow=False,
                )
            else:
                scene.remove_by_name("/nodes/masts")
            for tag_id in self._pins.keys() - placed.keys():
                scene.remove_by_name(self._pins[tag_id])
            for tag_id, alert in placed.items():
                place = (tags[tag_id]["x_m"], tags[tag_id]["y_m"], 0.0)
                self._show_pin(tag_id, alert, place, nodes.get(tag_id))

    def _show_pin(
        self, tag_id: str, alert: Value, place: tuple[float, float, float], node: Value | None
    ) -> None:
        name = self._pins.setdefault(tag_id, f"/nodes/alerts/{len(self._pins) + 1}")
        noted = alert["acknowledged_unix_s"] is not None
        color = self._palette["silent"] if noted else self._palette.alert(alert["severity"])
        scene = self._server.scene
        scene.add_frame(name, show_axes=False, position=place)
        scene.add_cylinder(
            f"{name}/pole", 0.03, _PIN_M, color, position=(0.0, 0.0, _PIN_M / 2.0), cast_shadow=False
        )
        scene.add_box(
            f"{name}/head",
            color,
            dimensions=(0.34, 0.34, 0.34),
            position=(0.0, 0.0, _PIN_M),
            cast_shadow=False,
            receive_shadow=False,
        )
        label = f"{tag_id}  {_words(alert, node)}"
        scene.add_label(f"{name}/label", label, position=(0.0, 0.0, _PIN_M + 0.35), anchor="bottom-center")


def _words(alert: Value, node: Value | None) -> str:
    """Return the reading that an alert is about, in short."""
    if node is not None and alert["kind"] == "hot":
        return f"{node['temperature_c']:.0f} °C"
    if node is not None and alert["kind"] == "pressure":
        return f"{node['pressure_hpa']:.0f} hPa"
    return _WORDS.get(alert["kind"], "alert")
