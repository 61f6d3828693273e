"""What the ground tells beside its walls: how well it was looked at, own maps, where robots were heard."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from robots.exploration.strategies.three_grids import three_grids
from robots.mapping.fused import FusedGrid
from robots.mapping.submap import unpack
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.se2 import Array, Pose2
from robots.team import TeamGrid
from robots.types import SubmapReport

SEEN, SAFE, CLEARED = 1, 2, 3
_CELL_M = 0.2  # how finely it is told how well ground was looked at
_OCCUPIED_FROM, _FREE_BELOW = 65, 35  # per cent, as ``server.map_image``
_SURE = 6  # tenths of log-odds: 65 and 35 per cent
_LATE_S = 5.0


def coarse(grid: TeamGrid) -> PlanGrid:
    """Return a grid of cells of about 0.2 m: occupied where any cell is, else free where any is."""
    factor = max(1, round(_CELL_M / grid.resolution_m))
    rows, columns = (-(-n // factor) for n in grid.cells.shape)
    cells = np.full((rows * factor, columns * factor), -1, np.int8)
    cells[: grid.cells.shape[0], : grid.cells.shape[1]] = grid.cells
    blocks = cells.reshape(rows, factor, columns, factor)
    known = np.full((rows, columns), UNKNOWN, np.uint8)
    known[((blocks >= 0) & (blocks < _FREE_BELOW)).any(axis=(1, 3))] = FREE
    known[(blocks >= _OCCUPIED_FROM).any(axis=(1, 3))] = OCCUPIED
    return PlanGrid(known, known, grid.origin_m, factor * grid.resolution_m)


def coverage(grid: TeamGrid, ways: Iterable[Array], safe_m: float) -> tuple[NDArray[np.uint8], float]:
    """Return how well the ground was looked at, uint8 (h, w), and the side of a cell in metres.

    0 unknown or occupied, 1 free, 2 safe (a robot was within ``safe_m`` of it, in sight), 3 cleared (its
    camera looked there), after Amigoni 2013, section 3.1. ``ways``: world poses (n, 3) of every robot.
    """
    plan = coarse(grid)
    way = np.concatenate([np.zeros((0, 3)), *ways])
    grids = three_grids(plan, way, safe_m)
    classes = np.zeros(plan.cells.shape, np.uint8)
    for mask, value in ((grids.free, SEEN), (grids.safe, SAFE), (grids.cleared, CLEARED)):
        classes[mask] = value
    return classes, plan.cell_m


def in_world(anchors: Array, way: Array) -> Array:
    """Return world poses (k, 3) of rows (n, 6) of ``TeamHost.way`` whose anchor is in the team map."""
    way = way[way[:, 2] < len(anchors)]
    at = anchors[way[:, 2].astype(int)]
    cosine, sine = np.cos(at[:, 2]), np.sin(at[:, 2])
    x = at[:, 0] + cosine * way[:, 3] - sine * way[:, 4]
    y = at[:, 1] + sine * way[:, 3] + cosine * way[:, 4]
    return np.column_stack((x, y, at[:, 2] + way[:, 5]))


def own_map(submaps: Iterable[SubmapReport], anchors: Array) -> TeamGrid | None:
    """Return one robot's submaps, drawn where the team map has their anchors; None without any."""
    drawn = [s for s in submaps if s.anchor < len(anchors)]
    if not drawn:
        return None
    fused = FusedGrid(drawn[0].resolution_m)
    for submap in drawn:
        place = Pose2.from_array(anchors[submap.anchor]) @ submap.anchor_from_grid
        fused.put(submap.anchor, submap.version, place, unpack(submap))
    cells, origin = fused.known()
    percent = np.full(cells.shape, 50, np.int8)
    percent[cells >= _SURE], percent[cells <= -_SURE], percent[cells == 0] = 100, 0, -1
    return TeamGrid(percent, origin, fused.resolution_m, 0) if cells.size else None


def came_late(stamps_s: Array, received_s: Array) -> NDArray[np.bool_]:
    """Return for each observation whether it came with others that are much newer: the robot was not heard.

    Both (n,) in the order of the log. Only differences of a robot's own stamps count, five seconds of its
    clock or, where a recording is played fast, of ours: neither clock has to be right.
    """
    if len(stamps_s) < 2:
        return np.zeros(len(stamps_s), np.bool_)
    rate = (stamps_s[-1] - stamps_s[0]) / max(1e-3, received_s[-1] - received_s[0])
    last = np.searchsorted(received_s, received_s + 0.5, side="right") - 1
    late: NDArray[np.bool_] = stamps_s[last] - stamps_s > _LATE_S * max(1.0, rate)
    return late
