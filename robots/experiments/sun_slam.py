"""RSLAM over a course among radio nodes, from a start that is known, and the maps that robots leave on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robots.config import AgentConfig, RadioConfig, RangeSlamConfig
from robots.estimation.anchor_log import AnchorLog
from robots.estimation.odometry import motion_covariance
from robots.estimation.radio.model import NODE, RadioModel
from robots.estimation.radio.signal_mean import robust_mean
from robots.estimation.rslam.left_map import LeftMap
from robots.estimation.rslam.range_slam import RangeSlam
from robots.estimation.tag_filter import RangeSighting
from robots.experiments.radio_course import ODOMETRY, RadioCourse
from robots.se2 import Array, GaussianPose, Pose2
from robots.tags.map_memory import WriterMap, merge_maps

Memories = dict[str, tuple[WriterMap, ...]]  # what is in each node

_ANCHOR_EVERY = 4  # steps
_SURVEYED = RangeSlamConfig(  # the radio's path loss was measured, and where the robots start
    scale_sd=0.03, starts_known=True
)


def run_slam(
    robot_id: str,
    course: RadioCourse,
    told: Array,
    level: float,
    radio: RadioConfig,
    seed: int,
    memories: Memories,
) -> Array:
    """Run RSLAM over a course and return where it has the robot at each step, (n, 2), online.

    ``memories`` are read; ``leave_map`` writes them.
    """
    slam = RangeSlam(robot_id, _config(radio, seed), Pose2.from_array(course.poses[0]), leaves_map=False)
    model, read, places = RadioModel(radio), dict[str, int](), []
    for step, heard in enumerate(course.heard):
        if step:
            slam.predict(_step(told[step - 1], level))
        for tag_id, readings in heard:
            ranged = _ranged(model, tag_id, readings, step)
            if ranged is not None:
                slam.see(ranged)
            for each in memories.get(tag_id, ()):
                if each.writer != robot_id and each.revision > read.get(each.writer, -1):
                    read[each.writer] = each.revision
                    slam.read_map(each)
        places.append((slam.belief.mean.x, slam.belief.mean.y))
    return np.array(places)


def leave_map(
    robot_id: str,
    course: RadioCourse,
    told: Array,
    level: float,
    radio: RadioConfig,
    seed: int,
    memories: Memories,
) -> None:
    """Let a robot leave what it maps by itself in the nodes it hears, as it drives."""
    left, log = LeftMap(_config(radio, seed), Pose2.from_array(course.poses[0])), AnchorLog(0.0, None)
    model, anchor_from_base = RadioModel(radio), GaussianPose.exact()
    for step, heard in enumerate(course.heard):
        if step:
            anchor_from_base = anchor_from_base @ _step(told[step - 1], level)
        if step % _ANCHOR_EVERY == 0 and step:
            log.add_anchor(anchor_from_base, float(step), None)
            anchor_from_base = GaussianPose.exact()
        for tag_id, readings in heard:
            ranged = _ranged(model, tag_id, readings, step)
            if ranged is not None:
                log.add_range(ranged, anchor_from_base)
        if left.is_due(log) or step == len(course.heard) - 1:
            left.solve(log)
            own = left.map(robot_id, step)
            for tag_id, _ in heard if own.beliefs else ():
                memories[tag_id] = merge_maps(memories.get(tag_id, ()), (own,))


def _config(radio: RadioConfig, seed: int) -> AgentConfig:
    return AgentConfig(seed=seed, radio=radio, rslam=_SURVEYED)


def _step(told: Array, level: float) -> GaussianPose:
    """Return the displacement that odometry tells, (2,), with its covariance."""
    noise = replace(
        ODOMETRY,
        distance_sd_per_sqrt_m=level * ODOMETRY.distance_sd_per_sqrt_m,
        turn_sd_per_sqrt_m=level * ODOMETRY.turn_sd_per_sqrt_m,
        turn_sd_per_sqrt_rad=level * ODOMETRY.turn_sd_per_sqrt_rad,
    )
    mean = Pose2(0.0, 0.0, float(told[1])) @ Pose2(float(told[0]), 0.0, 0.0)
    return GaussianPose(mean, motion_covariance(mean, noise, 0.2, None))


def _ranged(model: RadioModel, tag_id: str, readings: Array, step: int) -> RangeSighting | None:
    mean = robust_mean(readings, NODE.fading_sd_db)
    if mean is None:
        return None
    told = model.range_of(mean.rssi_dbm, mean.readings)
    return RangeSighting(
        tag_id,
        float(step),
        told.range_m,
        told.sd_m,
        log_sd=told.log_sd,
        median_m=told.median_m,
        independent=True,
    )
