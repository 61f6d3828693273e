"""Victims: a tall pin that shows over the walls, coloured by status, with its name."""

from __future__ import annotations

from typing import Any

import viser

from web.viser.colors import Palette

_PIN_M = 2.2


class VictimsLayer:
    """Draws each victim."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._scene = server.scene
        self._names: dict[str, str] = {}
        self._drawn: dict[str, tuple[object, ...]] = {}

    def put(self, victim_id: str, victim: dict[str, Any] | None) -> None:
        """Draw a victim of the board, or remove it."""
        name = self._names.setdefault(victim_id, f"/victims/{len(self._names) + 1}")
        if victim is None or victim.get("merged_into"):
            self._drawn.pop(victim_id, None)
            self._scene.remove_by_name(name)
            return
        looks = (victim["x_m"], victim["y_m"], victim["status"], f"{victim['confidence']:.0%}")
        if self._drawn.get(victim_id) == looks:  # it was only seen once more
            return
        self._drawn[victim_id] = looks
        color = self._palette.victim(victim["status"])
        self._scene.add_frame(name, show_axes=False, position=(victim["x_m"], victim["y_m"], 0.0))
        self._scene.add_cylinder(
            f"{name}/pole", 0.04, _PIN_M, color, position=(0.0, 0.0, _PIN_M / 2.0), cast_shadow=False
        )
        self._scene.add_icosphere(
            f"{name}/head", 0.26, color, position=(0.0, 0.0, _PIN_M), cast_shadow=False, receive_shadow=False
        )
        label = f"{victim_id}  {looks[-1]}"
        self._scene.add_label(
            f"{name}/label", label, position=(0.0, 0.0, _PIN_M + 0.35), anchor="bottom-center"
        )
