"""A robot that drives among radio nodes: noisy odometry, ranges with scale and offsets, all of it known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from robots.config import AgentConfig
from robots.estimation.rslam.range_slam import RangeSlam
from robots.estimation.tag_filter import RangeSighting
from robots.overrides import override
from robots.se2 import GaussianPose, Pose2

Reading = Callable[["World", str, float], float | None]


@dataclass
class World:
    """Nodes by name, the robot's true pose, and what its sensors do to the truth."""

    nodes: dict[str, tuple[float, float]]
    seed: int = 0
    range_sd_m: float = 0.2
    scale: float = 1.05
    offsets: dict[str, float] = field(default_factory=dict)
    motion_sd: tuple[float, float, float] = (0.02, 0.01, 0.01)  # of a step
    step_m: float = 0.5
    pose: Pose2 = field(default_factory=Pose2)
    seconds: float = 0.0

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)

    def step(self, slam: RangeSlam, reading: Reading | None = None, turn_rad: float | None = None) -> None:
        """Drive one step and hear every node once; ``reading`` may alter a range or drop it."""
        self.seconds += 1.0
        turn = self._steer() if turn_rad is None else turn_rad
        self.pose = self.pose @ Pose2(self.step_m, 0.0, turn)
        sd = np.array(self.motion_sd)
        told = np.array([self.step_m, 0.0, turn]) + self.random.normal(size=3) * sd
        slam.predict(GaussianPose(Pose2.from_array(told), np.diag(sd**2 + 1e-10)))
        for name in self.nodes:
            range_m: float | None = self.range_m(name)
            if reading is not None and range_m is not None:
                range_m = reading(self, name, range_m)
            if range_m is not None:
                slam.see(RangeSighting(name, self.seconds, range_m, max(self.range_sd_m, 1e-3)))

    def _steer(self) -> float:
        """Wind about, and turn back ten metres from the origin."""
        x, y = self.pose.inverse().transform_point(0.0, 0.0)
        if np.hypot(x, y) > 10.0:
            return float(np.clip(np.arctan2(y, x), -0.3, 0.3))
        return float(0.03 + 0.15 * np.sin(self.seconds / 7.0))

    def range_m(self, name: str) -> float:
        """A range to a node, as its radio measures it."""
        x, y = self.nodes[name]
        noise = self.random.normal() * self.range_sd_m
        true_m = np.hypot(x - self.pose.x, y - self.pose.y)
        return max(float(self.scale * true_m + self.offsets.get(name, 0.0) + noise), 0.0)

    def errors_m(self, slam: RangeSlam) -> dict[str, float]:
        """How far off each known node is."""
        return {
            name: float(np.hypot(tag.x_m - self.nodes[name][0], tag.y_m - self.nodes[name][1]))
            for name, tag in slam.tags().items()
        }


FOUR = {"a": (6.0, 9.0), "b": (-7.0, 4.0), "c": (2.0, -6.0), "d": (9.0, 1.0)}


def range_slam(seed: int = 0, robot_id: str = "r1", **changes: float) -> RangeSlam:
    """A filter that begins at the origin."""
    config = override(AgentConfig(), {"seed": seed, "rslam": changes})
    return RangeSlam(robot_id, config, Pose2())


def nees(belief: GaussianPose, truth: Pose2) -> float:
    """The squared error of a pose in units of its own covariance; 3 on average for an honest one."""
    off = belief.mean.as_array() - truth.as_array()
    off[2] = (off[2] + np.pi) % (2.0 * np.pi) - np.pi
    return float(off @ np.linalg.solve(belief.covariance + np.eye(3) * 1e-9, off))
