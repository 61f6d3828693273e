"""One range update of RSLAM with 1,000 particles of 50 nodes each, beside plainer ones, in turns."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from robots.config import AgentConfig
from robots.estimation.rslam.range_slam import RangeSlam
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2

_PARTICLES, _NODES, _ROUNDS = 1000, 50, 40
_STEP = GaussianPose(Pose2(0.2, 0.0, 0.02), np.diag([1e-4, 1e-4, 1e-5]))


def measure() -> dict[str, Any]:
    """Return times in milliseconds; medians of rounds in which each candidate has its turn.

    ``update_ms`` is everything that one range costs but resampling, ``with_resampling_ms`` the mean of all.
    ``numpy_ms`` is the same correction of place, offset and scale as array expressions;
    ``place_only_numpy_ms`` that of the place alone, as Sun 2009 prints it.
    """
    slam, world = _ready()
    kernel, places = _Plain(4), _Plain(2)
    times: dict[str, list[float]] = {"update_ms": [], "numpy_ms": [], "place_only_numpy_ms": []}
    everything = []
    for _ in range(_ROUNDS):
        steps = _round(slam, world)
        everything.extend(steps)
        times["update_ms"].append(1e3 * median(steps))
        times["numpy_ms"].append(_per_node(kernel.update))
        times["place_only_numpy_ms"].append(_per_node(places.update))
    result: dict[str, Any] = {"particles": _PARTICLES, "nodes": _NODES}
    result |= {name: median(values) for name, values in times.items()}
    result["update_ms_best"] = min(times["update_ms"])
    result["with_resampling_ms"] = 1e3 * float(np.mean(everything))
    result["times_numpy"] = result["numpy_ms"] / result["update_ms"]
    return result


class _World:
    def __init__(self) -> None:
        self._random = np.random.default_rng(1)
        self.nodes = self._random.uniform(-20.0, 20.0, (_NODES, 2))
        self.pose = Pose2()
        self._seconds = 0.0

    def move(self) -> None:
        self.pose = self.pose @ _STEP.mean
        self._seconds += 1.0

    def sighting(self, node: int) -> RangeSighting:
        x, y = self.nodes[node]
        range_m = 1.05 * np.hypot(x - self.pose.x, y - self.pose.y) + 0.2 + self._random.normal(0.0, 0.3)
        return RangeSighting(f"N{node}", self._seconds, max(float(range_m), 0.0), 0.3)


def _ready() -> tuple[RangeSlam, _World]:
    """Drive until every node has its place."""
    slam, world = RangeSlam("bench", AgentConfig(), Pose2()), _World()
    for _ in range(300):
        slam.predict(_STEP)
        world.move()
        for node in range(_NODES):
            slam.see(world.sighting(node))
        if len(slam.tags()) == _NODES:
            break
    return slam, world


def _round(slam: RangeSlam, world: _World) -> list[float]:
    slam.predict(_STEP)
    world.move()
    steps = []
    for node in range(_NODES):
        sighting = world.sighting(node)
        began = perf_counter()
        slam.see(sighting)
        steps.append(perf_counter() - began)
    return steps


def _per_node(update: Callable[[int], None]) -> float:
    began = perf_counter()
    for node in range(_NODES):
        update(node)
    return 1e3 * (perf_counter() - began) / _NODES


class _Plain:
    """Kalman filters of 2 (place) or 4 (and offset, and scale) states in all particles at once, by numpy."""

    def __init__(self, size: int) -> None:
        random = np.random.default_rng(2)
        self._means = random.uniform(-20.0, 20.0, (_NODES, _PARTICLES, size))
        self._spreads = np.tile(np.eye(size) * 0.1, (_NODES, _PARTICLES, 1, 1))
        self._robots: Array = random.normal(0.0, 0.1, (_PARTICLES, 2))
        self._weights = np.zeros(_PARTICLES)

    def update(self, node: int) -> None:
        mean, spread = self._means[node], self._spreads[node]
        apart = mean[:, :2] - self._robots
        d = np.hypot(apart[:, 0], apart[:, 1])
        by_state = np.ones_like(mean)
        by_state[:, :2] = apart / d[:, None]
        if mean.shape[1] == 4:
            by_state[:, 3] = d
        across = np.einsum("pij,pj->pi", spread, by_state)
        variance = np.einsum("pi,pi->p", by_state, across) + 0.09
        off = 15.0 - d - (mean[:, 2] if mean.shape[1] == 4 else 0.0)
        gain = across / variance[:, None]
        mean += gain * off[:, None]
        spread -= gain[:, :, None] * across[:, None, :]
        self._weights -= 0.5 * (off**2 / variance + np.log(variance))
        weights = np.exp(self._weights - self._weights.max())
        weights /= weights.sum()
