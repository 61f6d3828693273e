"""How the robots' map frames lie in the world.

Surveyed starts first, then from robot to robot by shared tags.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robots.se2 import Array, Pose2
from robots.team.types import StartPose
from robots.types import GraphReport

_BASELINE_M = 1.0  # two shared tags nearer than this say too little about the rotation


def join_frames(
    graphs: Mapping[str, GraphReport], starts: Mapping[str, StartPose | None]
) -> dict[str, Pose2]:
    """Return ``world_from_map`` of every robot that can be placed.

    Robots with a surveyed start stand where it says; if none has one, the first robot's map is the world.
    Every other robot joins when it shares tags with one that is placed: one tag is enough where both have a
    compass, else it takes two.
    """
    frames: dict[str, Pose2] = {}
    for name, graph in graphs.items():
        start = starts.get(name)
        if start is not None:
            frames[name] = start.pose @ Pose2.from_array(graph.poses[0]).inverse()
    if not frames and graphs:
        frames[min(graphs)] = Pose2()
    while True:
        waiting = [name for name in sorted(graphs) if name not in frames]
        joined = {name: frame for name in waiting if (frame := _joined(name, graphs, frames)) is not None}
        if not joined:
            return frames
        frames.update(joined)


def _joined(name: str, graphs: Mapping[str, GraphReport], frames: Mapping[str, Pose2]) -> Pose2 | None:
    """Return the frame of a robot from the tags it shares with those already placed.

    None where they do not suffice.
    """
    own = graphs[name]
    mine: list[Array] = []
    world: list[Array] = []
    compass_turn: float | None = None
    for other, frame in sorted(frames.items()):
        graph = graphs[other]
        index = {tag: k for k, tag in enumerate(graph.tag_ids)}
        shared = [(k, index[tag]) for k, tag in enumerate(own.tag_ids) if tag in index]
        if not shared:
            continue
        mine += [own.tags[k] for k, _ in shared]
        world += [frame.transform(graph.tags[j][None])[0] for _, j in shared]
        if compass_turn is None and np.isfinite(graph.yaws_rad).any() and np.isfinite(own.yaws_rad).any():
            compass_turn = frame.theta  # both maps point north
    if not mine:
        return None
    a, b = np.array(mine), np.array(world)
    middle_a, middle_b = a.mean(axis=0), b.mean(axis=0)
    turn = compass_turn
    if turn is None:
        if np.ptp(a, axis=0).max() < _BASELINE_M:
            return None
        da, db = a - middle_a, b - middle_b
        turn = float(np.arctan2((da[:, 0] * db[:, 1] - da[:, 1] * db[:, 0]).sum(), (da * db).sum()))
    rotated = Pose2(0.0, 0.0, turn).transform(middle_a[None])[0]
    return Pose2(float(middle_b[0] - rotated[0]), float(middle_b[1] - rotated[1]), turn)
