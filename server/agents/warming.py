"""Compiling the agent's kernels before the first robot needs them."""

from __future__ import annotations

import sys
from math import pi
from types import ModuleType

import numpy as np

from robots.config import AgentConfig
from robots.types import Displacement, HeatReading, ImuReading, LaserScan, Observation, TagSighting

_STEPS = 24


def warm_up(agent_module: ModuleType) -> None:
    """Let an agent drive a short way through a made-up room, so that every kernel is compiled or loaded.

    A failure is told on stderr and costs time later, nothing else.
    """
    try:
        agent = agent_module.RobotAgent("warm-up", AgentConfig())
        for seq in range(_STEPS):
            agent.step(_observation(seq))
        agent_module.RobotAgent.restore(agent.snapshot()).report()
    except Exception as error:
        print(f"waymark: the agent's warm-up failed: {error}", file=sys.stderr)


def _observation(seq: int) -> Observation:
    bearings = np.linspace(-2.0 * pi / 3.0, 2.0 * pi / 3.0, 240)
    x = 0.1 * seq
    with np.errstate(divide="ignore"):
        ahead = np.where(np.cos(bearings) > 0, (3.0 - x) / np.cos(bearings), (-1.0 - x) / np.cos(bearings))
        ranges = np.minimum(ahead, 1.5 / np.abs(np.sin(bearings)))
    scan = LaserScan(np.minimum(ranges, 5.0).astype(np.float32), bearings[0], bearings[1] - bearings[0], 4.0)
    return Observation(
        seq,
        0.2 * seq,
        odometry=Displacement(0.1, 0.0, 0.0),
        imu=ImuReading(0.0),
        scan=scan,
        tag_sightings=(TagSighting(f"T{seq // 12}"),) if seq % 6 == 3 else (),
        heat=(HeatReading(0.1, 1.5, 0.9),) if seq == 8 else (),
    )
