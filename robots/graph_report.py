"""The graph of one robot as it leaves the agent's process."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class GraphReport:
    """A robot's tag graph, whole: the latest replaces all earlier ones.

    Poses and tags in the robot's map frame: ``poses`` (n, 3) pose vertices (sighting poses, the first is the
    start), ``stamps_s`` (n,), ``yaws_rad`` (n,) IMU heading at each pose, NaN without IMU; ``tag_ids`` m
    names, ``tags`` (m, 2) tag points.

    ``edge_pairs`` (k, 2) pose indices i, j, ``edge_poses`` (k, 3) measured pose of j in i,
    ``edge_covariances`` (k, 3, 3).

    ``sighting_pairs`` (s, 2) pose index, tag index, ``sighting_offsets`` (s, 2) tag in the base frame,
    ``sighting_covariances`` (s, 2, 2) antenna footprint in the base frame.

    ``loop_pairs`` (l, 2) pose indices i, j that a laser match at a known tag joined, ``loop_poses`` (l, 3)
    matched pose of j in i, ``loop_covariances`` (l, 3, 3). A match can be wrong: solvers give it a kernel.

    ``meeting_robots`` r names of robots that were seen, ``meeting_poses`` (r,) index of the pose vertex,
    ``meeting_stamps_s`` (r,) when, ``meeting_offsets`` (r, 2) the other's base in the vertex' frame,
    ``meeting_covariances`` (r, 2, 2), ``meeting_bases`` (r, 3) the seer's own base in the vertex' frame then;
    without them it stood at the vertex.

    ``range_pairs`` (q, 2) pose index, tag index of tags that were seen by range; ``range_poses`` (q, 3) the
    antenna in the vertex' frame; ``ranges_m`` (q,) as measured, ``range_sds_m`` (q,) their deviations;
    ``bearings_rad`` (q,) from the antenna and ``bearing_sds_rad`` (q,), NaN where the radio has no direction.
    ``range_scale`` and ``range_offsets_m`` (m,) of each tag: what was learnt of the radios so far, measured =
    scale * true + offset. ``range_scale_sd`` and
    ``range_offset_sd_m``: how far radios of that kind are from 1 and 0.
    """

    poses: Array
    stamps_s: Array
    yaws_rad: Array
    tag_ids: tuple[str, ...]
    tags: Array
    edge_pairs: IntArray
    edge_poses: Array
    edge_covariances: Array
    sighting_pairs: IntArray
    sighting_offsets: Array
    sighting_covariances: Array
    loop_pairs: IntArray = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    loop_poses: Array = field(default_factory=lambda: np.zeros((0, 3)))
    loop_covariances: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    meeting_robots: tuple[str, ...] = ()
    meeting_poses: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    meeting_stamps_s: Array = field(default_factory=lambda: np.zeros(0))
    meeting_offsets: Array = field(default_factory=lambda: np.zeros((0, 2)))
    meeting_covariances: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))
    meeting_bases: Array = field(default_factory=lambda: np.zeros((0, 3)))
    range_pairs: IntArray = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    range_poses: Array = field(default_factory=lambda: np.zeros((0, 3)))
    ranges_m: Array = field(default_factory=lambda: np.zeros(0))
    range_sds_m: Array = field(default_factory=lambda: np.zeros(0))
    bearings_rad: Array = field(default_factory=lambda: np.zeros(0))
    bearing_sds_rad: Array = field(default_factory=lambda: np.zeros(0))
    range_scale: float = 1.0
    range_offsets_m: Array = field(default_factory=lambda: np.zeros(0))
    range_scale_sd: float = 0.1
    range_offset_sd_m: float = 0.3
