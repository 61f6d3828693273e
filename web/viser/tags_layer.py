"""Tags as one batch of flat hexagons, and the links between tags driven one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import cos, pi, sin
from typing import Any

import numpy as np
import viser

from web.viser.colors import TAG
from web.viser.shapes import prism, upright

_HEXAGON = prism([(0.16 * cos(i * pi / 3), 0.16 * sin(i * pi / 3)) for i in range(6)], 0.05)
_ABOVE_FLOOR_M = 0.03


class TagsLayer:
    """Draws all tags and links at once: they change seldom, and one node is cheap where hundreds are not."""

    def __init__(self, server: viser.ViserServer):
        self._server = server

    def show(self, tags: Mapping[str, dict[str, Any]], pairs: Iterable[tuple[str, str]]) -> None:
        """Replace tags and links by those of the board; ``tags`` by tag id."""
        scene = self._server.scene
        places = {tag_id: (tag["x_m"], tag["y_m"], _ABOVE_FLOOR_M) for tag_id, tag in tags.items()}
        lines = [(places[a], places[b]) for a, b in pairs if a in places and b in places]
        with self._server.atomic():
            if places:
                scene.add_batched_meshes_simple(
                    "/tags/points",
                    *_HEXAGON,
                    batched_wxyzs=upright(len(places)),
                    batched_positions=np.array(list(places.values()), np.float32),
                    batched_colors=TAG,
                    lod="off",
                    flat_shading=True,
                    cast_shadow=False,
                    receive_shadow=False,
                )
            else:
                scene.remove_by_name("/tags/points")
            if lines:
                scene.add_line_segments(
                    "/tags/links", np.array(lines, np.float32), TAG, thickness=1.0, thickness_units="screen"
                )
            else:
                scene.remove_by_name("/tags/links")
