"""Trajectories: stamped poses, and the final trajectory of a robot once its tag graph has been solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robots.graph_report import GraphReport
from robots.se2 import Array, Pose2, wrap_array

_TURNING_M_PER_RAD = 0.2  # a turn on the spot counts as so much travel when a correction is spread


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Stamped poses: ``stamps_s`` (n,) in seconds, NaN where there is none; ``poses`` (n, 3) x, y, theta."""

    stamps_s: Array
    poses: Array

    def __post_init__(self) -> None:
        if self.stamps_s.ndim != 1 or self.poses.shape != (len(self.stamps_s), 3):
            raise ValueError(f"{self.stamps_s.shape} stamps do not go with poses of shape {self.poses.shape}")

    def __len__(self) -> int:
        return len(self.stamps_s)


def in_order(trajectory: Trajectory) -> Trajectory:
    """Return the poses whose stamp is later than every stamp before it."""
    stamps = trajectory.stamps_s
    keep = np.isfinite(stamps)
    stamps, poses = stamps[keep], trajectory.poses[keep]
    later = np.concatenate([[True], stamps[1:] > np.maximum.accumulate(stamps)[:-1]])
    return Trajectory(stamps[later[: len(stamps)]], poses[later[: len(stamps)]])


@dataclass(frozen=True, slots=True)
class TrajectoryStep:
    """Where a robot was at one stamp, relative to a pose vertex of its graph, as estimated at that time."""

    stamp_s: float
    anchor: int
    anchor_from_base: Pose2


Edges = Mapping[tuple[int, int], Pose2]


def edges_of(graph: GraphReport) -> dict[tuple[int, int], Pose2]:
    """Return the measured displacements of a tag graph by their pair of pose vertices."""
    return {
        (int(pair[0]), int(pair[1])): Pose2.from_array(pose)
        for pair, pose in zip(graph.edge_pairs, graph.edge_poses, strict=True)
    }


def final_trajectory(steps: Sequence[TrajectoryStep], anchors: Array, edges: Edges) -> Trajectory:
    """Return the trajectory after the last solve of the graph.

    Every step hangs at the solved pose of its anchor. From one anchor to the next the robot drove an open
    chain of displacements which ended, as measured, at ``edges[a, b]``; the solution puts the next anchor
    elsewhere. That correction is spread along the way between the two (see ``_bend``), so the trajectory runs
    through every solved anchor without a jump, and is the measured one exactly where the solver changed
    nothing.

    Args:
        steps: in the order they were driven.
        anchors: (n, 3) solved poses of the pose vertices, in the frame wanted.
        edges: measured pose of vertex b in the frame of vertex a, as given to the solver. A pair that is
            missing leaves its segment as measured.

    Raises:
        ValueError: a step hangs at an anchor that has no solved pose.
    """
    poses = np.empty((len(steps), 3))
    start = 0
    while start < len(steps):
        anchor = steps[start].anchor
        if not 0 <= anchor < len(anchors):
            raise ValueError(f"step {start} hangs at anchor {anchor}, but only {len(anchors)} are solved")
        end = start
        while end < len(steps) and steps[end].anchor == anchor:
            end += 1
        local = np.array([step.anchor_from_base.as_array() for step in steps[start:end]])
        if end < len(steps) and 0 <= steps[end].anchor < len(anchors):
            following = steps[end].anchor
            measured = _measured(edges, anchor, following)
            if measured is not None:
                here, there = Pose2.from_array(anchors[anchor]), Pose2.from_array(anchors[following])
                local = _bend(local, measured, here.between(there))
        world = Pose2.from_array(anchors[anchor])
        poses[start:end, :2] = world.transform(local[:, :2])
        poses[start:end, 2] = wrap_array(local[:, 2] + world.theta)
        start = end
    return Trajectory(np.array([step.stamp_s for step in steps], dtype=np.float64), poses)


def _measured(edges: Edges, anchor: int, following: int) -> Pose2 | None:
    if (anchor, following) in edges:
        return edges[anchor, following]
    backward = edges.get((following, anchor))
    return backward.inverse() if backward is not None else None


def _bend(local: Array, measured: Pose2, solved: Pose2) -> Array:
    """Spread the correction of a segment's end, from ``measured`` to ``solved``, over its poses, (n, 3).

    The heading's correction grows in proportion to the distance travelled, as the error of dead reckoning
    does, and turns each small displacement by what it is there; what is left of the position's correction at
    the end is shifted in, again in proportion to the distance travelled.
    """
    chain = np.vstack([np.zeros(3), local, measured.as_array()])
    moved = np.diff(chain[:, :2], axis=0)
    turned = np.abs(wrap_array(np.diff(chain[:, 2])))
    travelled = np.concatenate(
        [[0.0], np.cumsum(np.hypot(moved[:, 0], moved[:, 1]) + _TURNING_M_PER_RAD * turned)]
    )
    fraction = travelled / travelled[-1] if travelled[-1] > 0.0 else np.linspace(0.0, 1.0, len(chain))
    turn = float(wrap_array(np.array([solved.theta - measured.theta]))[0])
    middle = turn * (fraction[1:] + fraction[:-1]) / 2.0
    c, s = np.cos(middle), np.sin(middle)
    turned_moves = np.column_stack([c * moved[:, 0] - s * moved[:, 1], s * moved[:, 0] + c * moved[:, 1]])
    positions = np.vstack([np.zeros(2), np.cumsum(turned_moves, axis=0)])
    rest = np.array([solved.x, solved.y]) - positions[-1]
    bent = np.column_stack([positions + fraction[:, None] * rest, wrap_array(chain[:, 2] + fraction * turn)])
    return np.asarray(bent[1:-1])
