"""A robot and its frontiers as they stand on the board, in the world frame."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robots.orders import Methods
from robots.se2 import Array
from server.robot import Robot


def robot_value(robot: Robot) -> dict[str, object] | None:
    """Return the robot's value on the board, in the world frame; None before anything was observed."""
    update, world_from_base, world_from_map = robot.update, robot.world_pose(), robot.world_from_map()
    if update is None or world_from_base is None or world_from_map is None:
        return None
    c, s = np.cos(world_from_map.theta), np.sin(world_from_map.theta)
    turned = np.array([[c, -s], [s, c]])
    covariance = np.array(update.covariance)
    covariance[:2, :2] = turned @ update.covariance[:2, :2] @ turned.T
    joint = robot.world_covariance()
    if joint is not None:
        covariance = joint
    goal = None if update.goal_m is None else _rounded(world_from_map.transform_point(*update.goal_m))
    path: Array = update.path_m.astype(np.float64)
    if len(path):
        path = world_from_map.transform(path)
    speed_mps = robot.stopping.speed_mps
    if speed_mps is None and not robot.is_agent_down:
        speed_mps = robot.speed_mps
    return {
        "robot_id": robot.robot_id,
        "x_m": round(world_from_base.x, 4),
        "y_m": round(world_from_base.y, 4),
        "yaw_rad": round(world_from_base.theta, 4),
        "covariance": [
            float(value) for value in (covariance[0, 0], covariance[0, 1], covariance[1, 1], covariance[2, 2])
        ],
        "stamp_s": update.stamp_s,
        "heard_unix_s": robot.heard_unix_s,
        "activity": update.activity,
        "reason": update.reason,
        "battery": robot.battery,
        "tags_left": update.tags_left,
        "agent": robot.record.agent,
        "slam": robot.slam,
        "methods": {name: getattr(update.methods, name) for name in Methods.__slots__},
        "stopped": robot.stopped,
        "stop_heard": robot.stopping.is_heard,
        "agent_down": robot.is_agent_down,
        "link": robot.link,
        "slipping": update.slipping,
        "located": robot.located,
        "explored_m2": round(update.explored_m2, 2),
        "distance_m": round(update.distance_m, 2),
        "goal_m": goal,
        "path_m": [_rounded(point) for point in path],
        "speed_mps": None if speed_mps is None else round(speed_mps, 3),
    }


def frontiers_value(robot: Robot) -> dict[str, object] | None:
    """Return ``frontiers/ID`` of the board, in the world frame; None before anything was observed."""
    world_from_map = robot.world_from_map()
    if world_from_map is None:
        return None
    edges = []
    for edge in robot.frontiers:
        x, y = world_from_map.transform_point(*edge.goal_m)
        edges.append(
            {
                "x_m": round(x, 2),
                "y_m": round(y, 2),
                "length_m": round(edge.length_m, 2),
                "worth_m": round(edge.worth_m, 2),
                "chosen": edge.chosen,
            }
        )
    return {"robot_id": robot.robot_id, "frontiers": edges}


def _rounded(point: Iterable[float]) -> list[float]:
    return [round(float(value), 3) for value in point]
