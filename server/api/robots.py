"""Robots: how they join, and how they are."""

from __future__ import annotations

import time
from typing import Any

from fastapi import APIRouter, Response

from db.records import RobotRecord, StartPoseRecord
from robots import codec
from robots.agent import RobotAgent
from robots.config import AgentConfig, ConfigError
from robots.overrides import override
from server.api.common import ERRORS, READS, OneMission, RobotOrOperator, TheChange
from server.board import Board
from server.errors import ApiError
from server.people.audit import AuditedRoute
from server.robot import Robot
from server.schemas.missions import RobotIn, RobotOut, RobotsOut, SilenceWire, StartPoseWire

router = APIRouter(
    prefix="/missions/{mission_id}/robots",
    tags=["robots"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="The robots of a mission", operation_id="get_robots")
async def get_robots(mission: OneMission) -> RobotsOut:
    """Return every robot in the order in which they registered."""
    return RobotsOut(robots=[_out(robot, mission.board) for robot in mission.roster.robots.values()])


@router.post("", status_code=201, summary="Join a mission", operation_id="register_robot")
async def register_robot(
    body: RobotIn, mission: OneMission, response: Response, by: RobotOrOperator, change: TheChange
) -> RobotOut:
    """Register a robot. The same words again are a re-join (200) and tell at which seq to go on."""
    if not by.is_for(mission.mission_id, body.robot_id):
        message = f"This token is not for {body.robot_id}; ask a commander for one for it."
        raise ApiError(403, "other_scope", message, "robot_id")
    change.subject = body.robot_id
    start = body.start_pose
    record = RobotRecord(
        mission_id=mission.mission_id,
        robot_id=body.robot_id,
        agent=body.agent,
        silence_after_s=body.silence.after_s,
        silence_policy=body.silence.policy,
        start_pose=None if start is None else StartPoseRecord(**start.model_dump()),
        config=codec.encode(_config(body, mission.roster.record.tag_key)),
        stopped=False,
        registered_unix_s=time.time(),
    )
    robot, is_new = await mission.register(record)
    response.status_code = 201 if is_new else 200
    return _out(robot, mission.board)


@router.get("/{robot_id}", summary="One robot", operation_id="get_robot")
async def get_robot(robot_id: str, mission: OneMission) -> RobotOut:
    """Return a robot with its latest state."""
    return _out(mission.roster.get(robot_id), mission.board)


def _config(body: RobotIn, tag_key: str) -> AgentConfig:
    """Return the robot's configuration: the mission's seal for tags, its surveyed start, what it asks for."""
    try:
        known: dict[str, Any] = {"tag_memory": {"key": tag_key}}
        if body.start_pose is not None:
            known["start"] = [body.start_pose.x_m, body.start_pose.y_m, body.start_pose.yaw_rad]
        config = override(override(AgentConfig(), known), body.config)
        RobotAgent(body.robot_id, config)  # a setting may name something that does not exist
    except ConfigError as error:
        field = str(error).split(" ", 1)[0].rstrip(":")
        raise ApiError(422, "invalid", f"{error}.", field) from error
    return config


def _out(robot: Robot, board: Board) -> RobotOut:
    record, start = robot.record, robot.record.start_pose
    return RobotOut(
        robot_id=record.robot_id,
        agent=record.agent,
        slam=robot.slam,
        silence=SilenceWire(after_s=record.silence_after_s, policy=record.silence_policy),
        start_pose=None
        if start is None
        else StartPoseWire(
            x_m=start.x_m, y_m=start.y_m, yaw_rad=start.yaw_rad, sd_m=start.sd_m, sd_rad=start.sd_rad
        ),
        next_seq=robot.next_seq,
        stopped=robot.stopped,
        link=robot.link,
        state=board.get(f"robot/{record.robot_id}"),
    )
