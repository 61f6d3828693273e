"""Edges of the unknown: a ring of dots where each robot could go, in its colour, and a mast where it goes."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import viser

from web.viser.colors import Palette

_ABOVE_FLOOR_M = 0.05
_RADIUS_M = 0.18
_MAST_M = 0.9
_SIDES = 12


class FrontiersLayer:
    """Draws the edges that each robot weighed last."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._scene = server.scene
        self._names: dict[str, str] = {}

    def put(self, robot_id: str, told: dict[str, Any] | None) -> None:
        """Draw the edges of a robot of the board anew, or remove them."""
        name = self._names.setdefault(robot_id, f"/frontiers/{len(self._names) + 1}")
        lines = [
            segments(each["x_m"], each["y_m"], each["chosen"]) for each in (told or {}).get("frontiers", [])
        ]
        if not lines:
            self._scene.remove_by_name(name)
            return
        color = self._palette.robot(robot_id)
        self._scene.add_line_segments(
            name, np.concatenate(lines), color, thickness=1.5, thickness_units="screen"
        )


def segments(x_m: float, y_m: float, is_chosen: bool) -> np.ndarray:
    """Return the lines of an edge's mark, (n, 2, 3): a ring on the floor, with a mast where it is chosen."""
    angles = np.linspace(0.0, 2.0 * pi, _SIDES + 1)
    ring = np.column_stack(
        (
            x_m + _RADIUS_M * np.cos(angles),
            y_m + _RADIUS_M * np.sin(angles),
            np.full(_SIDES + 1, _ABOVE_FLOOR_M),
        )
    )
    lines = np.stack((ring[:-1], ring[1:]), axis=1)
    if is_chosen:
        mast = np.array([[[x_m, y_m, _ABOVE_FLOOR_M], [x_m, y_m, _MAST_M]]])
        lines = np.concatenate((lines, mast))
    return lines.astype(np.float32)
