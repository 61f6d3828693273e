"""The colours of the scene, read from the one palette of all pages (static/palette.css)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

Rgb = tuple[int, int, int]

PALETTE_FILE = Path(__file__).parent.parent / "static" / "palette.css"
_BLOCK = re.compile(r':root(?:\[data-theme="(\w+)"\])? \{(.*?)\n\}', re.DOTALL)
_COLOR = re.compile(r"--([\w-]+): #([0-9a-f]{6})(?:[0-9a-f]{2})?;")


def read_palette(css: str) -> dict[str, dict[str, Rgb]]:
    """Return theme -> name -> colour; transparency is left out."""
    return {
        theme or "dark": {name: _rgb(code) for name, code in _COLOR.findall(block)}
        for theme, block in _BLOCK.findall(css)
    }


def _rgb(code: str) -> Rgb:
    return int(code[0:2], 16), int(code[2:4], 16), int(code[4:6], 16)


THEMES: Mapping[str, Mapping[str, Rgb]] = read_palette(PALETTE_FILE.read_text())
_DARK = THEMES["dark"]

ROBOT_COLORS: tuple[Rgb, ...] = tuple(_DARK[f"robot-{k}"] for k in range(1, 13))
GROUND = _DARK["unknown"]
FLOOR = _DARK["floor"]
WALL = _DARK["wall"]
TAG = _DARK["tag"]
DOUBTED_TAG = _DARK["doubted"]
SILENT = _DARK["silent"]
ALERT_COLORS: dict[str, Rgb] = {"warning": _DARK["warn"], "alarm": _DARK["danger"]}
VICTIM_COLORS: dict[str, Rgb] = {
    "suspected": _DARK["warn"],
    "confirmed": _DARK["danger"],
    "reached": _DARK["accent"],
    "extricated": _DARK["good"],
    "dismissed": SILENT,
}


def robot_index(robot_id: str) -> int:
    """Return which of the robots' colours is its: r1, r2, ... in order, any other name by its letters.

    FNV-1a, 32 bit.
    """
    number = re.search(r"([0-9]{1,9})$", robot_id)
    if number and int(number[1]) > 0:
        return (int(number[1]) - 1) % len(ROBOT_COLORS)
    value = 0x811C9DC5
    for byte in robot_id.encode():
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return value % len(ROBOT_COLORS)


def robot_color(robot_id: str) -> Rgb:
    """Return the robot's colour, the same as on the console's plan (static/console/color.js)."""
    return ROBOT_COLORS[robot_index(robot_id)]
