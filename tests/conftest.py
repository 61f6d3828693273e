"""What tests all over the tree share: finite differences, a robot's log, and hypothesis made repeatable."""

import os
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from robots.agent import RobotAgent
from robots.config import AgentConfig, DeploymentConfig
from robots.se2 import Pose2, wrap
from robots.types import (
    Command,
    HeatReading,
    ImuReading,
    LaserScan,
    Observation,
    TagSighting,
    WheelEncoders,
)
from tests.loaded import servers_fork_from_one

settings.register_profile(
    "waymark",
    deadline=None,
    derandomize=True,
    max_examples=80,
    suppress_health_check=[HealthCheck.too_slow],  # timing never decides a test
)
settings.load_profile("waymark")


@pytest.hookimpl(optionalhook=True)  # xdist may be switched off
def pytest_xdist_auto_num_workers() -> int:
    """One more than there are processors: stories wait, for pages and for servers."""
    return len(os.sched_getaffinity(0)) + 1


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Workers get files with a browser among the others, evenly, and short ones last."""
    if not hasattr(config, "workerinput"):
        return
    in_browser = {item.path for item in items if "browser" in getattr(item, "fixturenames", ())}
    tests = Counter(item.path for item in items)
    files = sorted(tests, key=lambda path: (-tests[path], path in in_browser and -path.stat().st_size, path))
    of_kind, seen = Counter(path in in_browser for path in files), Counter[bool]()
    turn = {}
    for path in files:
        kind = path in in_browser
        turn[path] = (seen[kind] + 0.5) / of_kind[kind]
        seen[kind] += 1
    items.sort(key=lambda item: (turn[item.path], item.path))


@pytest.fixture(scope="session", autouse=True)
def _servers_fork_from_one() -> Iterator[None]:
    yield from servers_fork_from_one()


Vector = np.ndarray
Jacobian = Callable[[Callable[[Vector], Vector], Vector], np.ndarray]


def _numerical_jacobian(function: Callable[[Vector], Vector], at: Vector) -> np.ndarray:
    """Central differences of a function of (n,) with values (m,), as (m, n)."""
    at = np.asarray(at, dtype=float)
    step = 1e-6
    columns = []
    for k in range(len(at)):
        ahead, behind = at.copy(), at.copy()
        ahead[k] += step
        behind[k] -= step
        columns.append((np.asarray(function(ahead)) - np.asarray(function(behind))) / (2.0 * step))
    return np.column_stack(columns)


@pytest.fixture(scope="session")
def numerical_jacobian() -> Jacobian:
    return _numerical_jacobian


_WALLS = np.array(  # x0, y0, x1, y1: a corridor along x with two rooms on either side, and their doors
    [
        [-1.5, -4.0, 7.5, -4.0],
        [7.5, -4.0, 7.5, 4.0],
        [7.5, 4.0, -1.5, 4.0],
        [-1.5, 4.0, -1.5, -4.0],
        [3.0, -4.0, 3.0, -0.8],
        [3.0, 0.8, 3.0, 4.0],
        *([x, y, x + 1.7, y] for y in (-0.8, 0.8) for x in (-1.5, 1.3, 3.0, 5.8)),
    ]
)
_VICTIM = (2.2, 0.3)
_TAGS = {"T0": (0.0, 0.0), "T1": (0.75, 0.8), "T2": (0.75, -0.8), "T3": (5.2, 0.8), "T4": (2.5, 0.0)}
_ANGLES = np.linspace(-2.0, 2.0, 161)
_RANGE_MAX_M = 3.0


def _ranges(pose: Pose2, angles: np.ndarray) -> np.ndarray:
    """Distance to the nearest wall along each bearing, at most the laser's range."""
    direction = np.stack([np.cos(pose.theta + angles), np.sin(pose.theta + angles)])  # (2, n)
    start, along = _WALLS[:, :2] - (pose.x, pose.y), _WALLS[:, 2:] - _WALLS[:, :2]  # (w, 2)
    cross = along[:, :1] * direction[1] - along[:, 1:] * direction[0]  # (w, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (along[:, 0] * start[:, 1] - along[:, 1] * start[:, 0])[:, None] / cross
        share = (direction[0] * start[:, 1:] - direction[1] * start[:, :1]) / cross
    distance[~((share >= 0.0) & (share <= 1.0) & (distance > 0.0))] = np.inf
    return np.minimum(distance.min(axis=0), _RANGE_MAX_M)


def _explore(config: AgentConfig, seconds: float) -> tuple[Observation, ...]:
    rng = np.random.default_rng(3)
    agent = RobotAgent("r1", config)
    pose, command = Pose2(0.0, 0.0, 0.4), Command()
    tags, memories = dict(_TAGS), dict.fromkeys(_TAGS, b"")
    log: list[Observation] = []
    for seq in range(int(seconds * 20)):
        forward, turned = command.linear_mps / 20, command.angular_radps / 20
        moved = pose @ Pose2.exp(np.array([forward, 0.0, turned]))
        bumped = bool(_ranges(moved, np.linspace(-np.pi, np.pi, 48)).min() < 0.2)
        if bumped:
            moved, forward = Pose2(pose.x, pose.y, moved.theta), 0.0
        pose = moved
        left, right = (forward + side * 0.2 * turned + rng.normal(0.0, 5e-4) for side in (-1.0, 1.0))
        bearing = wrap(np.arctan2(_VICTIM[1] - pose.y, _VICTIM[0] - pose.x) - pose.theta)
        distance = float(np.hypot(_VICTIM[0] - pose.x, _VICTIM[1] - pose.y))
        warm = seq % 10 == 0 and distance < 2.5 and abs(bearing) < 1.0
        ranges = _ranges(pose, _ANGLES)
        ranges += np.where(ranges < _RANGE_MAX_M, rng.normal(0.0, 0.01, len(_ANGLES)), 0.0)
        scan = LaserScan(ranges.astype(np.float32), -2.0, float(_ANGLES[1] - _ANGLES[0]), _RANGE_MAX_M)
        near = [tag for tag, (x, y) in tags.items() if np.hypot(x - pose.x, y - pose.y) < 0.2]
        observation = Observation(
            seq=seq,
            stamp_s=seq / 20,
            odometry=WheelEncoders(left, right, left, right),
            imu=ImuReading(wrap(pose.theta + rng.normal(0.0, 1e-3))),
            scan=scan if seq % 4 == 0 else None,
            tag_sightings=tuple(TagSighting(tag, memories[tag]) for tag in near),
            heat=(HeatReading(bearing, distance + rng.normal(0.0, 0.1), 0.8),) if warm else (),
            bumper=bumped,
        )
        log.append(observation)
        update = agent.step(observation)
        command = update.command if observation.scan is not None else replace(command, drop_tag=False)
        memories.update({write.tag_id: write.memory for write in update.command.writes})
        if command.drop_tag:
            dropped = f"T{len(tags)}"
            tags[dropped], memories[dropped] = (pose.x, pose.y), b""
    return tuple(log)


@dataclass(frozen=True)
class RobotLog:
    config: AgentConfig
    observations: tuple[Observation, ...]


@pytest.fixture(scope="session")
def robot_log() -> RobotLog:
    """A minute of one robot exploring a corridor and four rooms, dropping tags, passing a victim."""
    config = AgentConfig(deployment=DeploymentConfig(spacing_m=2.0, rate_per_m=3.0))
    return RobotLog(config, _explore(config, 60.0))
