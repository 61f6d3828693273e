"""The union of the robots' tag graphs as one problem in the world frame."""

from __future__ import annotations

from math import atan2, cos, sin

import numpy as np

from robots.estimation.graph import GraphProblem
from robots.se2 import Array, Pose2, wrap
from robots.team.types import StartPose
from robots.types import GraphReport, IntArray

_HEADING_SD_RAD = 0.035  # of a compass, for minutes at a time
_BIAS_SD_RAD = 0.0175  # by which the compasses of two robots differ
_HELD_SD = 1e-3  # what holds the world in place where nobody surveyed it


def joint_problem(
    names: list[str],
    graphs: dict[str, GraphReport],
    starts: dict[str, StartPose | None],
    frames: dict[str, Pose2],
    tag_ids: list[str],
) -> tuple[GraphProblem, dict[str, int]]:
    """Return the union of the robots' graphs in the world frame, and where each robot's poses begin in it."""
    tag_index = {tag: k for k, tag in enumerate(tag_ids)}
    tags = np.zeros((len(tag_ids), 2))
    offsets: dict[str, int] = {}
    count = 0
    parts: dict[str, list[Array]] = {key: [] for key in ("poses", "prior_poses", "prior_sds")}
    pairs_of: dict[str, list[IntArray]] = {key: [] for key in ("edges", "sightings")}
    priors: list[int] = []
    heading_index, headings = [], []
    surveyed = any(starts[name] is not None for name in names)
    norths = _norths(names, graphs, starts)
    for name in reversed(names):  # the first robot's places of shared tags are the ones that stand
        placed = frames[name].transform(graphs[name].tags)
        for tag, place in zip(graphs[name].tag_ids, placed, strict=True):
            tags[tag_index[tag]] = place
    for name in names:
        graph, frame, start = graphs[name], frames[name], starts[name]
        offsets[name] = count
        poses = moved(frame, graph.poses)
        parts["poses"].append(poses)
        pairs_of["edges"].append(graph.edge_pairs + count)
        to_team = np.array([tag_index[tag] for tag in graph.tag_ids], np.int64)
        pairs = graph.sighting_pairs.copy()
        if len(pairs):
            pairs = np.column_stack([pairs[:, 0] + count, to_team[pairs[:, 1]]])
        pairs_of["sightings"].append(pairs)
        if start is not None or (name == names[0] and not surveyed):
            priors.append(count)
            parts["prior_poses"].append(poses[:1] if start is None else start.pose.as_array()[None])
            sds = [_HELD_SD] * 3 if start is None else [start.sd_m, start.sd_m, start.sd_rad]
            parts["prior_sds"].append(np.maximum([sds], _HELD_SD))
        known = np.flatnonzero(np.isfinite(graph.yaws_rad))
        heading_index.append(known + count)
        headings.append(graph.yaws_rad[known] + norths.get(name, frame.theta))
        count += len(poses)
    heading = np.concatenate(headings)
    return (
        GraphProblem(
            poses=np.concatenate(parts["poses"]),
            tags=tags,
            edge_pairs=np.concatenate(pairs_of["edges"]).astype(np.int64),
            edge_poses=np.concatenate([graphs[name].edge_poses for name in names]),
            edge_covariances=np.concatenate([graphs[name].edge_covariances for name in names]),
            sighting_pairs=np.concatenate(pairs_of["sightings"]).astype(np.int64),
            sighting_offsets=np.concatenate([graphs[name].sighting_offsets for name in names]),
            sighting_covariances=np.concatenate([graphs[name].sighting_covariances for name in names]),
            prior_index=np.array(priors, np.int64),
            prior_poses=np.concatenate(parts["prior_poses"]),
            prior_sds=np.concatenate(parts["prior_sds"]),
            heading_index=np.concatenate(heading_index).astype(np.int64),
            heading_rad=heading,
            heading_sd_rad=np.full(len(heading), _HEADING_SD_RAD),
        ),
        offsets,
    )


def moved(frame: Pose2, poses: Array) -> Array:
    """Return poses (n, 3) in the frame's parent."""
    moved = poses.copy()
    moved[:, :2] = frame.transform(poses[:, :2])
    moved[:, 2] += frame.theta
    return moved


def _norths(
    names: list[str], graphs: dict[str, GraphReport], starts: dict[str, StartPose | None]
) -> dict[str, float]:
    """Return the heading of north in the world as each robot's compass shows it; empty without a survey.

    A surveyed heading tells it for its own robot, as surely as it claims to. Compasses differ by no more than
    their biases, so the surveys of the team tell it for a robot that has none or a vague one.
    """
    turns: dict[str, float] = {}
    variances: dict[str, float] = {}
    for name in names:
        start, yaw = starts[name], graphs[name].yaws_rad[0]
        if start is not None and np.isfinite(yaw):
            turns[name] = wrap(start.pose.theta - float(yaw))
            variances[name] = max(start.sd_rad, _HELD_SD) ** 2
    if not turns:
        return {}
    weights = {name: 1.0 / (variances[name] + _BIAS_SD_RAD**2) for name in turns}
    common = atan2(
        sum(weights[name] * sin(turn) for name, turn in turns.items()),
        sum(weights[name] * cos(turn) for name, turn in turns.items()),
    )
    vague = 1.0 / sum(weights.values()) + _BIAS_SD_RAD**2  # of the common one, for one robot's compass
    norths = {name: common for name in names if np.isfinite(graphs[name].yaws_rad).any()}
    for name, turn in turns.items():
        norths[name] = common + wrap(turn - common) * vague / (vague + variances[name])
    return norths
