"""The building: free floor as an image, walls extruded from the occupied cells as one batched mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import viser
from numpy.typing import NDArray

from web.viser.colors import Palette, Rgb
from web.viser.shapes import unit_box, upright

WALL_HEIGHT_M = 1.4  # low enough to look over, high enough to read as a room
OCCUPIED_FROM = 65  # of 100, as ROS map_server has it
LYING_FACE_UP = (
    0.0,
    1.0,
    0.0,
    0.0,
)  # viser's images have y down: a half turn about x lays row 0 at the far side

Cells = NDArray[np.int8]


class Grid(NamedTuple):
    """An occupancy grid: ``cells`` (h, w), -1 unknown, 0..100; ``origin_m`` is the corner of cell (0, 0)."""

    cells: Cells
    origin_m: tuple[float, float]
    resolution_m: float


class MapLayer:
    """Draws the latest grid."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._palette = palette
        self._server = server

    def show(self, grid: Grid) -> None:
        """Replace floor and walls by those of the grid."""
        height, width = grid.cells.shape
        x_m, y_m = grid.origin_m
        size_m = (width * grid.resolution_m, height * grid.resolution_m)
        boxes = wall_boxes(grid.cells)
        corners = boxes[:, :2] * grid.resolution_m + (x_m, y_m)
        with self._server.atomic():
            self._server.scene.add_image(
                "/map/floor",
                floor_image(grid.cells, self._palette["floor"]),
                *size_m,
                format="png",
                wxyz=LYING_FACE_UP,
                position=(x_m + size_m[0] / 2.0, y_m + size_m[1] / 2.0, 0.0),
                cast_shadow=False,
                receive_shadow=False,
            )
            if not len(boxes):
                self._server.scene.remove_by_name("/map/walls")
                return
            box = unit_box()
            self._server.scene.add_batched_meshes_simple(
                "/map/walls",
                box.vertices,
                box.faces,
                batched_wxyzs=upright(len(boxes)),
                batched_positions=np.column_stack((corners, np.zeros(len(boxes)))).astype(np.float32),
                batched_scales=np.column_stack(
                    (boxes[:, 2:] * grid.resolution_m, np.full(len(boxes), WALL_HEIGHT_M))
                ).astype(np.float32),
                batched_colors=self._palette["wall"],
                lod="off",
                flat_shading=True,
                cast_shadow=False,
                receive_shadow=False,
            )


def floor_image(cells: Cells, floor: Rgb) -> NDArray[np.uint8]:
    """Return RGBA, shape (h, w, 4), row 0 at the largest y: known cells as floor, unknown ones clear."""
    image = np.zeros((*cells.shape, 4), np.uint8)
    image[cells[::-1] >= 0] = (*floor, 255)
    return image


def wall_boxes(cells: Cells) -> NDArray[np.int64]:
    """Return rectangles that cover the occupied cells once: (n, 4), column, row, width, height in cells.

    Runs along each row, joined with equal runs of the rows above: a building becomes a few thousand boxes.
    """
    occupied = cells >= OCCUPIED_FROM
    edges = np.diff(np.pad(occupied.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    starts, ends = np.argwhere(edges == 1), np.argwhere(edges == -1)
    boxes: list[list[int]] = []
    open_boxes: dict[tuple[int, int], list[int]] = {}  # run -> the box that grows upwards from it
    row_now = -1
    still_open: dict[tuple[int, int], list[int]] = {}
    for (row, first), end in zip(starts.tolist(), ends[:, 1].tolist(), strict=True):
        if row != row_now:
            open_boxes = still_open if row == row_now + 1 else {}
            still_open = {}
            row_now = row
        box = open_boxes.get((first, end))
        if box is None:
            box = [first, row, end - first, 0]
            boxes.append(box)
        box[3] += 1
        still_open[first, end] = box
    return np.array(boxes, np.int64).reshape(-1, 4)
