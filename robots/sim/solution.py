"""What a team believes at the end of a simulated mission, solved together, against the truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robots.evaluation import EvaluationError, absolute_error
from robots.outputs import write_team, write_trajectories
from robots.se2 import Pose2
from robots.sim.runner import RobotResult, SimulationResult
from robots.sim.scenario import START_SD_M, START_SD_RAD
from robots.team import StartPose, TeamMap, TeamRobot, TeamUpdate
from robots.trajectory import Trajectory, TrajectoryStep, edges_of, final_trajectory


@dataclass(frozen=True, slots=True, eq=False)
class SolvedRobot:
    """One robot's trajectories in the world frame."""

    robot_id: str
    online: Trajectory
    final: Trajectory
    truth: Trajectory

    @property
    def ate_m(self) -> float | None:
        """Absolute error of the final trajectory; None when the mission was too short to align anything."""
        try:
            return absolute_error(self.final, self.truth).rmse_m
        except EvaluationError:
            return None


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """The joint solution of a mission."""

    robots: tuple[SolvedRobot, ...]
    team: TeamUpdate

    def ate_m(self) -> dict[str, float | None]:
        """Return the absolute trajectory error of each robot."""
        return {robot.robot_id: robot.ate_m for robot in self.robots}

    def write(self, folder: Path) -> None:
        """Write trajectories, tags and map to a folder."""
        for robot in self.robots:
            write_trajectories(folder, robot.robot_id, robot.online, robot.final)
        write_team(folder, self.team)


def solve(result: SimulationResult) -> Solution:
    """Solve the graphs of all robots together and place every robot's trajectory in that solution."""
    team = TeamMap(result.config.agent_config.mapping.resolution_m)
    for robot in result.robots:
        team.add_robot(robot.robot_id, StartPose(robot.start, START_SD_M, START_SD_RAD))
        team.put(robot.robot_id, robot.report)
    solved = team.solve()
    by_id = {robot.robot_id: robot for robot in solved.robots}
    return Solution(tuple(_solved(robot, by_id[robot.robot_id]) for robot in result.robots), solved)


def _solved(robot: RobotResult, solved: TeamRobot) -> SolvedRobot:
    steps = [
        TrajectoryStep(float(stamp), int(anchor), Pose2.from_array(pose))
        for stamp, anchor, pose in zip(robot.stamps_s, robot.anchors, robot.anchors_from_base, strict=True)
    ]
    edges = edges_of(robot.report.graph) if robot.report.graph is not None else {}
    online = np.array([(robot.world_from_map @ Pose2.from_array(row)).as_array() for row in robot.poses])
    return SolvedRobot(
        robot_id=robot.robot_id,
        online=Trajectory(robot.stamps_s, online.reshape(-1, 3)),
        final=final_trajectory(steps, solved.anchors, edges),
        truth=Trajectory(robot.stamps_s, robot.truths),
    )
