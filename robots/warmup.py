"""Compiling the numerical kernels ahead of time.

It takes seconds at the first start of a machine, nothing afterwards.
"""

from __future__ import annotations

from math import radians

import numpy as np

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.estimation.graph import solve
from robots.estimation.tag_graph import TagGraph, graph_problem
from robots.se2 import GaussianPose, Pose2
from robots.team import StartPose, TeamMap
from robots.types import ImuReading, LaserScan, Observation, TagSighting, WheelEncoders


def warm_up() -> None:
    """Drive an agent and a team map a few steps, so that every kernel is compiled and cached."""
    agent = RobotAgent("warm-up", AgentConfig())
    angles = np.linspace(-2.0, 2.0, 240)
    ranges = np.minimum(
        2.0 / np.maximum(np.abs(np.cos(angles)), 1e-3), 2.5 / np.maximum(np.abs(np.sin(angles)), 1e-3)
    )
    scan = LaserScan(np.minimum(ranges, 4.0).astype(np.float32), -2.0, float(angles[1] - angles[0]), 4.0)
    team = TeamMap()
    team.add_robot("warm-up", StartPose(Pose2(), 0.1, radians(1.0)))
    for seq in range(12):
        update = agent.step(
            Observation(
                seq=seq,
                stamp_s=0.2 * seq,
                odometry=WheelEncoders(0.02, 0.02, 0.02, 0.02),
                imu=ImuReading(0.0),
                scan=scan,
                tag_sightings=(TagSighting(f"warm-{seq % 3}"),) if seq > 3 else (),
                bumper=seq == 9,
            )
        )
        team.put("warm-up", update)
    team.put("warm-up", agent.report())
    team.solve()
    RobotAgent.restore(agent.snapshot())
    _warm_up_bad_starts()


def _warm_up_bad_starts() -> None:
    """Solve a small loop from a start that is in doubt: its kernels are needed rarely, and then at once."""
    graph = TagGraph(AgentConfig(), Pose2(), 0.0, None)
    for turn in range(4):
        graph.add_pose(GaussianPose(Pose2(1.0, 0.0, radians(90.0)), np.eye(3) * 1e-2), float(turn), None)
        graph.add_sighting(f"warm-{turn % 2}", (0.0, 0.0), np.eye(2) * 1e-2)
    solve(graph_problem(graph.report()), start="relaxed")
