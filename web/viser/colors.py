"""The colours of the scene, read from the one palette of all pages (static/palette.css)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

Rgb = tuple[int, int, int]
ROBOTS = 12  # colours for them

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


@dataclass(frozen=True, slots=True)
class Palette:
    """The colours of a scene in one theme."""

    theme: str = "dark"

    def __getitem__(self, name: str) -> Rgb:
        """Return the colour of that name in ``static/palette.css``."""
        return THEMES[self.theme][name]

    def robot(self, robot_id: str) -> Rgb:
        """Return a robot's colour."""
        return robot_color(robot_id, self.theme)

    def alert(self, severity: str) -> Rgb:
        """Return the colour of an alert by its severity."""
        return self[{"warning": "warn", "alarm": "danger"}.get(severity, "silent")]

    def victim(self, status: str) -> Rgb:
        """Return the colour of a victim by its status."""
        names = {"suspected": "warn", "confirmed": "danger", "reached": "accent", "extricated": "good"}
        return self[names.get(status, "silent")]


def robot_index(robot_id: str) -> int:
    """Return which of the robots' colours is its: r1, r2, ... in order, any other name by its letters.

    FNV-1a, 32 bit.
    """
    number = re.search(r"([0-9]{1,9})$", robot_id)
    if number and int(number[1]) > 0:
        return (int(number[1]) - 1) % ROBOTS
    value = 0x811C9DC5
    for byte in robot_id.encode():
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return value % ROBOTS


def robot_color(robot_id: str, theme: str = "dark") -> Rgb:
    """Return the robot's colour, the same as on the console's plan (static/console/color.js)."""
    return THEMES[theme][f"robot-{1 + robot_index(robot_id)}"]
