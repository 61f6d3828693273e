"""A course: what truly happened while a robot explored a building, kept to put noise on it again and again.

The robot is told where it truly is, drops its tags by its own rule and passes over them as the paths of its
planner have it. What a noisy robot would have measured on the same way is drawn afterwards (``reckoning``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np
from numpy.typing import NDArray

from robots.agent import RobotAgent
from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.graph_report import IntArray
from robots.se2 import Array, Pose2
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.types import Displacement, LaserScan, Observation, WheelEncoders

ROBOT = "r1"
# "the robot distributed approximately 50 RFID tags" on the small map (Kleiner 2006, below figure 5)
DENSE = DeploymentConfig(magazine=1000, spacing_m=2.0, rate_per_m=3.0)
_LEAST_MINUTES, _MINUTES_PER_M2 = 5.0, 0.05  # an exploration takes about half of that
_LASER_HZ = 2.5
_FRAME_EVERY_M = 0.5
_BEAMS = 24  # of each scan are kept


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """One exploration of a building of ``area_m2`` free floor, n ticks of ``dt_s``.

    ``poses`` (n, 3) true poses of the base in the world; ``speeds_mps``, ``turns_radps`` (n,) what the wheels
    ran at in the tick before each; ``pressed`` (n,) against something. ``sighting_ticks``, ``sighting_tags``
    (s,) readings of tags, in order; ``tags_m`` (m, 2) where those truly lie. ``frames`` (f,) ticks at which a
    scan is kept, whose points ``frame_points`` (f, b, 2) are in the base frame, NaN where nothing was hit.
    ``explored`` says whether the robot came to an end.
    """

    area_m2: float
    dt_s: float
    poses: Array
    speeds_mps: Array
    turns_radps: Array
    pressed: NDArray[np.bool_]
    sighting_ticks: IntArray
    sighting_tags: IntArray
    tags_m: Array
    frames: IntArray
    frame_points: Array
    explored: bool

    @property
    def distance_m(self) -> float:
        """The way driven."""
        steps = np.diff(self.poses[:, :2], axis=0)
        return float(np.hypot(steps[:, 0], steps[:, 1]).sum())

    @property
    def repeats(self) -> int:
        """Readings of tags that had been read before: what closes loops, and what repeats a pass."""
        return len(self.sighting_ticks) - len(self.tags_m)


def explore(map_spec: str, seed: int, minutes: float | None = None, searches: int = 2) -> Course:
    """Let one robot explore a building until nothing is left, or for so long at most.

    Raises:
        WorldError, ScenarioError: the building cannot be had; the message says why.
    """
    scenario = ScenarioConfig(
        map=map_spec,
        robots=1,
        seed=seed,
        noise_level=0,
        victims=0,
        imu=False,
        laser_hz=_LASER_HZ,
        agent_config=AgentConfig(deployment=DENSE, planning=PlanningConfig(replan_every_s=2.0)),
    )
    simulation = Simulation(scenario)
    area_m2 = simulation.world.free_area_m2
    limit_s = 60.0 * (_LEAST_MINUTES + _MINUTES_PER_M2 * area_m2 if minutes is None else minutes)
    log: list[Observation] = []
    explored = True
    for search in range(searches):
        explored &= _search(simulation, search, limit_s, log)
    poses = np.array([everybody[0] for everybody in simulation.track])
    dt_s = scenario.period_s / scenario.ticks_per_period
    wheels = np.array([_wheels(observation) for observation in log])  # exact: their noise level is 0
    track_m = scenario.agent_config.body.track_width_m
    ids = {tag.tag_id: index for index, tag in enumerate(simulation.tags.tags)}
    read = [(observation.seq, ids[s.tag_id]) for observation in log for s in observation.tag_sightings]
    frames = _frames(poses, log)
    return Course(
        area_m2=area_m2,
        dt_s=dt_s,
        poses=poses,
        speeds_mps=wheels.mean(axis=1) / dt_s,
        turns_radps=(wheels[:, 1] - wheels[:, 0]) / track_m / dt_s,
        pressed=np.array([observation.bumper for observation in log]),
        sighting_ticks=np.array([tick for tick, _ in read], np.int64),
        sighting_tags=np.array([tag for _, tag in read], np.int64),
        tags_m=simulation.tags.places_m,
        frames=frames,
        frame_points=np.array([_points(log[tick].scan) for tick in frames]).reshape(-1, _BEAMS, 2),
        explored=explored,
    )


def _search(simulation: Simulation, number: int, limit_s: float, log: list[Observation]) -> bool:
    """Search the building once, with an agent that knows nothing of it; say whether it came to an end.

    The agent is told once a period what happened in it.
    """
    scenario = simulation.config
    agent = RobotAgent(ROBOT, replace(scenario.agent_of(ROBOT), poses="truth", seed=scenario.seed + number))
    before, end_s = simulation.truth(ROBOT), simulation.clock_s + limit_s
    period = 0
    while simulation.clock_s < end_s:
        observations = simulation.advance()[ROBOT]
        log.extend(observations)
        here = simulation.truth(ROBOT)
        moved, before = before.between(here), here
        update = agent.step(as_moved(observations, period, moved))
        period += 1
        simulation.apply({ROBOT: Order(update.command)})
        if update.activity == "done":
            return True
    return False


def as_moved(observations: Sequence[Observation], seq: int, moved: Pose2) -> Observation:
    """Return observations as one, with how the robot truly moved in place of what its wheels say."""
    return replace(
        observations[-1],
        seq=seq,
        odometry=Displacement(moved.x, moved.y, moved.theta),
        tag_sightings=tuple(s for each in observations for s in each.tag_sightings),
        bumper=any(each.bumper for each in observations),
    )


def _wheels(observation: Observation) -> tuple[float, float]:
    """Return what the left and the right wheels rolled, in metres."""
    odometry = observation.odometry
    assert isinstance(odometry, WheelEncoders)
    return odometry.front_left_m, odometry.front_right_m


def _frames(poses: Array, log: list[Observation]) -> IntArray:
    frames: list[int] = []
    for observation in log:
        if observation.scan is None:
            continue
        x, y, _ = poses[observation.seq]
        if not frames or hypot(x - poses[frames[-1], 0], y - poses[frames[-1], 1]) >= _FRAME_EVERY_M:
            frames.append(observation.seq)
    return np.array(frames, np.int64)


def _points(scan: LaserScan | None) -> Array:
    """Return where some of a scan's beams end, (b, 2) in the base frame, NaN for those that hit nothing."""
    assert scan is not None
    kept = np.linspace(0, len(scan.ranges_m) - 1, _BEAMS).round().astype(int)
    ranges = scan.ranges_m[kept].astype(np.float64)
    ranges[~(ranges < scan.range_max_m)] = np.nan
    angles = scan.angle_min_rad + scan.angle_increment_rad * kept
    return np.column_stack([ranges * np.cos(angles), ranges * np.sin(angles)])
