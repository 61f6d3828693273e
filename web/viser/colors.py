"""The colours of the scene. Robots have the same ones as on the console's plan (static/console/color.js)."""

from __future__ import annotations

import re

Rgb = tuple[int, int, int]

ROBOT_COLORS: tuple[Rgb, ...] = tuple(
    (int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16))
    for code in (
        "#5cb8ff", "#ffb454", "#3ddbb0", "#f59bd0", "#f4e36b", "#a99bff",
        "#b5e36e", "#e5a78c", "#6fe3f2", "#d48bff", "#9fb8cc", "#e8dcc0",
    )
)  # fmt: skip
GROUND: Rgb = (10, 14, 20)
FLOOR: Rgb = (44, 58, 78)
WALL: Rgb = (196, 209, 226)
TAG: Rgb = (255, 243, 196)
DOUBTED_TAG: Rgb = (255, 138, 76)
SILENT: Rgb = (120, 132, 148)
ALERT_COLORS: dict[str, Rgb] = {"warning": (255, 190, 77), "alarm": (255, 90, 95)}
VICTIM_COLORS: dict[str, Rgb] = {
    "suspected": (255, 190, 77),
    "confirmed": (255, 90, 95),
    "reached": (92, 207, 255),
    "extricated": (69, 214, 160),
    "dismissed": (120, 132, 148),
}


def robot_color(robot_id: str) -> Rgb:
    """Return the robot's colour: r1, r2, ... in order, any other name by its letters (FNV-1a, 32 bit)."""
    number = re.search(r"([0-9]{1,9})$", robot_id)
    if number and int(number[1]) > 0:
        return ROBOT_COLORS[(int(number[1]) - 1) % len(ROBOT_COLORS)]
    value = 0x811C9DC5
    for byte in robot_id.encode():
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return ROBOT_COLORS[value % len(ROBOT_COLORS)]
