"""The plan that was there before the mission, faint on the floor: the map that robots make lies over it."""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from web.viser.colors import Palette
from web.viser.map_layer import LYING_FACE_UP, OCCUPIED_FROM, Cells, Grid

_UNDER_FLOOR_M = 0.05  # nearer, and from afar it shows through
_OPACITY = 0.4  # as on the plan (static/console/css/map.css)
_MOST_PIXELS = 2048  # along a side: graphics cards take twice that


class BaseLayer:
    """Draws the latest base map."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._scene = server.scene

    def show(self, grid: Grid | None) -> None:
        """Replace the base map, or take it away."""
        if grid is None:
            self._scene.remove_by_name("/base")
            return
        cells, (x_m, y_m), resolution_m = thinned(grid, _MOST_PIXELS)
        size_m = (cells.shape[1] * resolution_m, cells.shape[0] * resolution_m)
        self._scene.add_image(
            "/base",
            self._image(cells),
            *size_m,
            format="png",
            wxyz=LYING_FACE_UP,
            position=(x_m + size_m[0] / 2.0, y_m + size_m[1] / 2.0, -_UNDER_FLOOR_M),
            cast_shadow=False,
            receive_shadow=False,
        )

    def _image(self, cells: Cells) -> NDArray[np.uint8]:
        """Return RGBA, shape (h, w, 4), row 0 at the largest y: unknown cells clear."""
        image = np.zeros((*cells.shape, 4), np.uint8)
        opacity = round(255 * _OPACITY)
        image[cells[::-1] >= 0] = (*self._palette["floor"], opacity)
        image[cells[::-1] >= OCCUPIED_FROM] = (*self._palette["wall"], opacity)
        return image


def thinned(grid: Grid, most: int) -> Grid:
    """Return a grid joined in squares until neither side is longer than ``most``; a wall in one stays.

    Squares are whole: at the far sides they reach out of the grid, into what is unknown.
    """
    height, width = grid.cells.shape
    by = -(-max(height, width) // most)
    if by == 1:
        return grid
    rows, columns = -(-height // by), -(-width // by)
    padded = np.full((rows * by, columns * by), -1, np.int8)
    padded[:height, :width] = grid.cells
    joined = padded.reshape(rows, by, columns, by).max(axis=(1, 3))
    return Grid(joined, grid.origin_m, grid.resolution_m * by)
