"""Trails: where each robot has been, as one line on the floor per robot."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from web.viser.colors import Palette

_ABOVE_FLOOR_M = 0.04


class TrailsLayer:
    """Draws each robot's trail."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._scene = server.scene
        self._names: dict[str, str] = {}

    def put(self, robot_id: str, trail: dict[str, Any] | None) -> None:
        """Draw a trail of the board anew, or remove it."""
        name = self._names.setdefault(robot_id, f"/trails/{len(self._names) + 1}")
        points = np.array(trail["points_m"] if trail else [], np.float32).reshape(-1, 2)
        if len(points) < 2:
            self._scene.remove_by_name(name)
            return
        line = np.column_stack((points, np.full(len(points), _ABOVE_FLOOR_M, np.float32)))
        self._scene.add_line_segments(
            name,
            np.stack((line[:-1], line[1:]), axis=1),
            self._palette.robot(robot_id),
            thickness=2.5,
            thickness_units="screen",
        )
