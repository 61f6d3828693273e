"""What a run leaves in a folder: trajectories, tags and the map, in formats other tools read."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image

from robots.team import TeamGrid, TeamTag, TeamUpdate
from robots.trajectory import Trajectory
from robots.tum import write_tum

UNKNOWN, FREE_BELOW, OCCUPIED_FROM = -1, 50, 65  # of an int8 grid, 0..100

# How map_server maps a grey level: p = (255 - grey) / 255, occupied above occupied_thresh, free below
# free_thresh. 205 gives p = 0.1961. The customary free_thresh of 0.196 is under it by 0.0001, that of newer
# tools (0.25) is above it, which turns all that is unknown into free space; 0.15 leaves a margin that no
# rounding eats.
_FREE_GREY, _UNKNOWN_GREY, _OCCUPIED_GREY = 254, 205, 0
_MAP_YAML = """\
image: {image}
mode: trinary
resolution: {resolution:.6g}
origin: [{x:.6f}, {y:.6f}, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.15
"""


def write_trajectories(folder: Path, robot_id: str, online: Trajectory, final: Trajectory) -> None:
    """Write ``trajectory_<robot>.tum``, as it was estimated, and ``_final.tum``, after the last solve."""
    folder.mkdir(parents=True, exist_ok=True)
    write_tum(folder / f"trajectory_{robot_id}.tum", online)
    write_tum(folder / f"trajectory_{robot_id}_final.tum", final)


def write_tags(folder: Path, tags: Iterable[TeamTag]) -> None:
    """Write ``tags.csv``: ``tag_id,x_m,y_m,var_x,var_xy,var_y``, variances in square metres."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "tags.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["tag_id", "x_m", "y_m", "var_x", "var_xy", "var_y"])
        for tag in tags:
            variances = (tag.covariance[0, 0], tag.covariance[0, 1], tag.covariance[1, 1])
            row = [f"{tag.x_m:.6f}", f"{tag.y_m:.6f}", *(f"{variance:.9g}" for variance in variances)]
            writer.writerow([tag.tag_id, *row])


def write_map(folder: Path, grid: TeamGrid | None) -> None:
    """Write ``map.png`` and ``map.yaml`` for map_server; without a grid, one unknown cell.

    Cells between free (under 50) and occupied (from 65) are written as unknown: three classes survive a round
    trip.
    """
    if grid is None or not grid.cells.size:
        grid = TeamGrid(np.full((1, 1), UNKNOWN, np.int8), (0.0, 0.0), 0.05, 0)
    folder.mkdir(parents=True, exist_ok=True)
    grey = np.full(grid.cells.shape, _UNKNOWN_GREY, np.uint8)
    grey[(grid.cells >= 0) & (grid.cells < FREE_BELOW)] = _FREE_GREY
    grey[grid.cells >= OCCUPIED_FROM] = _OCCUPIED_GREY
    Image.fromarray(np.ascontiguousarray(grey[::-1])).save(folder / "map.png")  # row 0 of an image is its top
    x, y = grid.origin_m
    text = _MAP_YAML.format(image="map.png", resolution=grid.resolution_m, x=x, y=y)
    (folder / "map.yaml").write_text(text, encoding="utf-8")


def write_team(folder: Path, team: TeamUpdate) -> None:
    """Write the tags and the map of a joint solution."""
    write_tags(folder, team.tags)
    write_map(folder, team.grid)
