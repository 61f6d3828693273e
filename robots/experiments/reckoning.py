"""What an agent without laser makes of a course: dead reckoning by noisy wheels, and the tag graph.

The agent's own equations over a whole course at once, in milliseconds instead of minutes; a test holds them
against ``RobotAgent`` itself. The map frame is the agent's: at the start, its x axis north where there is an
inertial unit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from robots.config import AgentConfig, BodyConfig, OdometryConfig
from robots.estimation.tag_graph.graph import TagGraph
from robots.experiments.course import Course
from robots.graph_report import IntArray
from robots.se2 import Array, GaussianPose, Pose2, wrap_array
from robots.sim.wheels import Imu, Wheels, data_sheet
from robots.trajectory import TrajectoryStep

_SAME_PASS_M = 0.4  # as the agent has it
_STEP_EVERY_S = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What the sensors say on a course: ``wheels`` (n, 4) metres, ``yaws_rad`` (n,) None without IMU."""

    wheels: Array
    yaws_rad: Array | None


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """From one vertex to the next: the displacement measured, the heading read there, the tags passed."""

    displacement: GaussianPose
    stamp_s: float
    yaw_rad: float | None
    tags: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Reckoned:
    """What the agent has measured, and the way as dead reckoning has it.

    ``world_from_map`` where the map frame truly lies. ``legs`` lead from vertex to vertex, the first being
    the start. ``ticks`` (k,) at which the way is looked at: ``steps`` k places relative to the vertices,
    ``poses`` (k, 3) in the map frame by dead reckoning alone.
    """

    config: AgentConfig
    world_from_map: Pose2
    start: Pose2
    start_yaw_rad: float | None
    legs: tuple[Leg, ...]
    ticks: IntArray
    steps: list[TrajectoryStep]
    poses: Array

    def graph(self, online: bool) -> TagGraph:
        """Return the tag graph, not solved yet; or solved at every tag known by then, as the agent does."""
        antenna = self.config.antenna
        spread = np.diag(antenna.variances)
        graph = TagGraph(self.config, self.start, self.steps[0].stamp_s, self.start_yaw_rad)
        for leg in self.legs:
            graph.add_pose(leg.displacement, leg.stamp_s, leg.yaw_rad)
            news = [graph.add_sighting(str(tag), (antenna.ahead_m, 0.0), spread) for tag in leg.tags]
            if online and any(news):
                graph.solve()
        return graph


def firm_floor(level: int, body: BodyConfig) -> OdometryConfig:
    """Return what an agent is told of wheels of a noise level; floors do not slip in these experiments."""
    return replace(data_sheet(level, body.track_width_m), slip="off")


def read_sensors(
    course: Course,
    level: int,
    config: AgentConfig,
    wheels: np.random.Generator,
    imu: np.random.Generator | None,
) -> Readings:
    """Draw what wheels of a noise level, and an inertial unit where given a generator, say on a course."""
    encoders = Wheels(level, config.body.track_width_m, wheels)
    grips = np.ones(len(course.poses))
    yaws = None
    if imu is not None:
        yaws = Imu(None, False, imu).yaws(course.poses[:, 2], course.dt_s)
    return Readings(encoders.read_all(course.speeds_mps, course.turns_radps, course.dt_s, grips), yaws)


def reckon(course: Course, readings: Readings, config: AgentConfig) -> Reckoned:
    """Return what the agent has on a course before its graph is solved."""
    motions, variances = _motions(course, readings, config)
    driven = np.cumsum(np.hypot(motions[:, 0], motions[:, 1]))
    passes = _passes(course, driven, config.mapping.submap_travel_m)
    restarts = np.array(list(passes), np.int64)
    since, displacements, covariances = _dead_reckon(motions, variances, restarts)
    yaws = readings.yaws_rad
    legs = tuple(
        Leg(
            GaussianPose(Pose2.from_array(displacements[row]), covariances[row]),
            course.dt_s * (tick + 1),
            None if yaws is None else float(yaws[tick]),
            tuple(tags),
        )
        for row, (tick, tags) in enumerate(passes.items())
    )
    looked = np.arange(0, len(motions), max(1, round(_STEP_EVERY_S / course.dt_s)))
    ticks = np.union1d(looked, course.frames)
    vertices = np.searchsorted(restarts, ticks, side="right")
    steps = [
        TrajectoryStep(course.dt_s * (int(tick) + 1), int(vertex), Pose2.from_array(since[tick]))
        for tick, vertex in zip(ticks, vertices, strict=True)
    ]
    start = Pose2() if yaws is None else Pose2(0.0, 0.0, float(yaws[0]))
    chain = [start]
    for leg in legs:
        chain.append(chain[-1] @ leg.displacement.mean)
    x, y, _ = course.poses[0]
    return Reckoned(
        config=config,
        world_from_map=Pose2(x, y, 0.0) if yaws is not None else Pose2.from_array(course.poses[0]),
        start=start,
        start_yaw_rad=None if yaws is None else float(yaws[0]),
        legs=legs,
        ticks=ticks,
        steps=steps,
        poses=_composed(np.array([pose.as_array() for pose in chain])[vertices], since[ticks]),
    )


def _motions(course: Course, readings: Readings, config: AgentConfig) -> tuple[Array, Array]:
    """Return each tick's motion, (n, 3) in the base frame before it, and the diagonal of its Sigma_u, (n, 3).

    The first observation starts the map: what was driven before is no part of it.
    """
    body, noise = config.body, config.odometry
    left, right = readings.wheels[:, ::2].mean(axis=1), readings.wheels[:, 1::2].mean(axis=1)
    distance, turn = (left + right) / 2.0, (right - left) / body.track_width_m
    if readings.yaws_rad is not None:
        turn = np.concatenate([[0.0], wrap_array(np.diff(readings.yaws_rad))])
    half = turn / 2.0
    chord = distance * np.sinc(half / np.pi)  # an exact arc
    along, across = chord * np.cos(half), chord * np.sin(half)
    slipping = course.pressed
    along, across = np.where(slipping, 0.0, along), np.where(slipping, 0.0, across)
    motions = np.column_stack([along, across, wrap_array(turn)])
    motions[0] = 0.0
    moved, turned = np.hypot(motions[:, 0], motions[:, 1]), np.abs(motions[:, 2])
    arm_m = body.track_width_m / 2.0
    slip = np.where(slipping, noise.slip_sd_per_sqrt_s**2 * course.dt_s, 0.0)
    variances = np.column_stack(
        [
            noise.distance_sd_per_sqrt_m**2 * (moved + turned * arm_m) + slip,
            noise.lateral_sd_per_sqrt_m**2 * moved,
            noise.turn_sd_per_sqrt_m**2 * moved + noise.turn_sd_per_sqrt_rad**2 * turned + slip / arm_m**2,
        ]
    )
    if readings.yaws_rad is not None:
        variances[:, 2] = config.imu.yaw_drift_sd_rad**2 * course.dt_s
        variances[0, 2] = 0.0
    return motions, variances


def _passes(course: Course, driven: Array, travel_m: float) -> dict[int, list[int]]:
    """Return the ticks at which the filter is restarted, in order, each with the tags newly passed there."""
    readings: dict[int, list[int]] = {}
    for tick, tag in zip(course.sighting_ticks.tolist(), course.sighting_tags.tolist(), strict=True):
        readings.setdefault(tick, []).append(tag)
    passes: dict[int, list[int]] = {}
    last: tuple[int, float] | None = None
    anchored_m = 0.0
    for tick in [*readings, len(driven)]:
        overdue = int(np.searchsorted(driven, anchored_m + travel_m, side="right"))
        while overdue < tick:
            passes[overdue] = []
            anchored_m = float(driven[overdue])
            overdue = int(np.searchsorted(driven, anchored_m + travel_m, side="right"))
        if tick == len(driven):
            break
        here = float(driven[tick])
        fresh = [
            tag for tag in readings[tick] if last is None or last[0] != tag or here - last[1] > _SAME_PASS_M
        ]
        if fresh or overdue == tick:
            passes[tick] = fresh
            anchored_m = here
        if fresh:
            last = fresh[-1], here
    return passes


def _composed(parents: Array, children: Array) -> Array:
    """Return ``parent @ child`` row by row, all (n, 3)."""
    c, s = np.cos(parents[:, 2]), np.sin(parents[:, 2])
    x, y = children[:, 0], children[:, 1]
    turned = np.column_stack([c * x - s * y, s * x + c * y, children[:, 2]])
    return np.column_stack([(parents + turned)[:, :2], wrap_array(parents[:, 2] + children[:, 2])])


@njit(cache=True)
def _dead_reckon(motions: Array, variances: Array, restarts: IntArray) -> tuple[Array, Array, Array]:
    """Eq. (1) and (2) of Kleiner 2006 from restart to restart.

    Return the pose since the last restart after each tick, (n, 3), and the displacement, (r, 3), with its
    covariance, (r, 3, 3), measured at each restart.
    """
    since = np.empty_like(motions)
    displacements = np.empty((len(restarts), 3))
    covariances = np.empty((len(restarts), 3, 3))
    pose = np.zeros(3)
    covariance = np.zeros((3, 3))
    by_pose, by_motion = np.eye(3), np.eye(3)
    following = 0
    for k in range(len(motions)):
        c, s = np.cos(pose[2]), np.sin(pose[2])
        dx = c * motions[k, 0] - s * motions[k, 1]
        dy = s * motions[k, 0] + c * motions[k, 1]
        by_pose[0, 2], by_pose[1, 2] = -dy, dx
        by_motion[0, 0], by_motion[0, 1], by_motion[1, 0], by_motion[1, 1] = c, -s, s, c
        covariance = by_pose @ covariance @ by_pose.T + by_motion @ np.diag(variances[k]) @ by_motion.T  # (2)
        pose[0] += dx  # (1)
        pose[1] += dy
        pose[2] += motions[k, 2]
        if following < len(restarts) and restarts[following] == k:
            displacements[following] = pose
            covariances[following] = covariance
            pose[:] = 0.0
            covariance = np.zeros((3, 3))
            following += 1
        since[k] = pose
    return since, displacements, covariances
