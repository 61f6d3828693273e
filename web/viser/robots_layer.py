"""Robots: a body that points where the robot heads, its name, and the 2-sigma ellipse of its position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import viser

from web.viser.colors import Palette
from web.viser.shapes import ellipse, prism, turn_z, unit_disc

_BODY = prism([(0.6, 0.0), (-0.42, 0.4), (-0.26, 0.0), (-0.42, -0.4)], 0.35)
_DISC = unit_disc()
_SMALLEST_M = 0.02  # an ellipse of no size at all cannot be scaled


@dataclass(slots=True)
class _Robot:
    """The nodes of one robot."""

    frame: Any
    body: Any
    ellipse: Any
    color: tuple[int, int, int]


class RobotsLayer:
    """Draws each robot at its latest pose."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._scene = server.scene
        self._robots: dict[str, _Robot] = {}
        self._count = 0

    def put(self, robot_id: str, robot: dict[str, Any] | None) -> None:
        """Draw a robot of the board, or remove it."""
        if robot is None:
            if gone := self._robots.pop(robot_id, None):
                gone.frame.remove()
                gone.ellipse.remove()
            return
        nodes = self._robots.get(robot_id) or self._add(robot_id)
        x_m, y_m = robot["x_m"], robot["y_m"]
        nodes.frame.position = (x_m, y_m, 0.03)
        nodes.frame.wxyz = turn_z(robot["yaw_rad"])
        color = self._palette.robot(robot_id) if robot.get("link") == "live" else self._palette["silent"]
        if color != nodes.color:
            nodes.body.color = nodes.ellipse.color = nodes.color = color
        shape = ellipse(*robot["covariance"][:3])
        nodes.ellipse.position = (x_m, y_m, 0.02)
        nodes.ellipse.wxyz = turn_z(shape.angle_rad)
        nodes.ellipse.scale = (max(shape.major_m, _SMALLEST_M), max(shape.minor_m, _SMALLEST_M), 1.0)

    def _add(self, robot_id: str) -> _Robot:
        # The node's name is ours: an id from outside could hold a slash and hang itself below another node.
        self._count += 1
        name, color = f"/robots/{self._count}", self._palette.robot(robot_id)
        frame = self._scene.add_frame(name, show_axes=False)
        body = self._scene.add_mesh_simple(
            f"{name}/body", *_BODY, color=color, flat_shading=True, cast_shadow=False, receive_shadow=False
        )
        self._scene.add_label(
            f"{name}/label",
            robot_id,
            position=(0.0, 0.0, 0.7),
            anchor="bottom-center",
            font_screen_scale=0.85,
        )
        disc = self._scene.add_mesh_simple(
            f"/ellipses/{self._count}",
            *_DISC,
            color=color,
            opacity=0.3,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )
        self._robots[robot_id] = _Robot(frame, body, disc, color)
        return self._robots[robot_id]
