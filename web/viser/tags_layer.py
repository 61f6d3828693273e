"""Tags as one batch of flat hexagons, and the links between tags driven one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import cos, pi, sin
from typing import Any

import numpy as np
import viser

from web.viser.colors import Palette, Rgb
from web.viser.shapes import Mesh, prism, upright

_HEXAGON = prism([(0.16 * cos(i * pi / 3), 0.16 * sin(i * pi / 3)) for i in range(6)], 0.05)
_STAR = [0.26, 0.12]  # a doubted tag has points, so that it stands out without its colour
_POINTED = prism([(_STAR[i % 2] * cos(i * pi / 6), _STAR[i % 2] * sin(i * pi / 6)) for i in range(12)], 0.12)
_ABOVE_FLOOR_M = 0.03


class TagsLayer:
    """Draws all tags and links at once: they change seldom, and one node is cheap where hundreds are not."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._server = server

    def show(self, tags: Mapping[str, dict[str, Any]], pairs: Iterable[tuple[str, str]]) -> None:
        """Replace tags and links by those of the board; ``tags`` by tag id."""
        scene = self._server.scene
        places = {tag_id: (tag["x_m"], tag["y_m"], _ABOVE_FLOOR_M) for tag_id, tag in tags.items()}
        lines = [(places[a], places[b]) for a, b in pairs if a in places and b in places]
        doubted = [tag_id for tag_id, tag in tags.items() if tag.get("state", "sound") != "sound"]
        sound = [places[tag_id] for tag_id in places if tag_id not in doubted]
        with self._server.atomic():
            self._show_points("/tags/points", _HEXAGON, sound, self._palette["tag"])
            astray = [places[tag_id] for tag_id in doubted]
            self._show_points("/tags/doubted", _POINTED, astray, self._palette["doubted"])
            if lines:
                scene.add_line_segments(
                    "/tags/links",
                    np.array(lines, np.float32),
                    self._palette["tag"],
                    thickness=1.0,
                    thickness_units="screen",
                )
            else:
                scene.remove_by_name("/tags/links")

    def _show_points(
        self, name: str, shape: Mesh, places: list[tuple[float, float, float]], color: Rgb
    ) -> None:
        scene = self._server.scene
        if not places:
            scene.remove_by_name(name)
            return
        scene.add_batched_meshes_simple(
            name,
            *shape,
            batched_wxyzs=upright(len(places)),
            batched_positions=np.array(places, np.float32),
            batched_colors=color,
            lod="off",
            flat_shading=True,
            cast_shadow=False,
            receive_shadow=False,
        )
