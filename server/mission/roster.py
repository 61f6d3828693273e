"""The robots of a mission: how they join, and how they stand on the board."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import replace

import structlog

from db.records import MissionRecord, RobotRecord
from db.store import Store
from server.agents.host import AgentHost
from server.agents.process import ForkServer
from server.board import Board
from server.errors import ApiError, unknown
from server.mission.alerts import Alerts
from server.mission.tasks import Tasks
from server.robot import Robot, RobotLog
from server.robot_value import frontiers_value, robot_value

log = structlog.get_logger()


class Roster:
    """The robots by id. ``record`` is the mission's own, ``stopped_all`` in it meant for robots to come."""

    def __init__(
        self,
        record: MissionRecord,
        store: Store,
        forks: ForkServer,
        board: Board,
        alerts: Alerts,
        tasks: Tasks,
    ) -> None:
        self.record = record
        self.robots: dict[str, Robot] = {}
        self._store = store
        self._forks = forks
        self._board = board
        self._alerts = alerts
        self._tasks = tasks
        self._registering = asyncio.Lock()
        self.publish()

    def get(self, robot_id: str) -> Robot:
        """Return a robot.

        Raises:
            ApiError: there is none of that name.
        """
        if robot_id not in self.robots:
            raise unknown("robot", robot_id)
        return self.robots[robot_id]

    async def register(self, record: RobotRecord) -> tuple[Robot, bool]:
        """Save and add a robot, or let it join again with the same words; say whether it is new.

        Raises:
            ApiError: a robot of that name registered otherwise.
        """
        async with self._registering:
            known = self.robots.get(record.robot_id)
            if known is not None:
                if known.record.registration() != record.registration():
                    raise ApiError(
                        409,
                        "robot_differs",
                        f"Robot {record.robot_id!r} registered otherwise;"
                        " repeat its words or take another name.",
                        "robot_id",
                    )
                return known, False
            record = replace(record, stopped=self.record.stopped_all)
            await self._store.missions.register_robot(record)
            robot = self.add(record, done_seq=-1)
            if self.record.stopped_all != record.stopped:  # STOP for all came while it was being saved
                robot.set_stopped(self.record.stopped_all)
                await self._store.missions.record_stop(
                    self.record.mission_id, [record.robot_id], stopped=robot.stopped, all_=robot.stopped
                )
            return robot, True

    def add(self, record: RobotRecord, done_seq: int) -> Robot:
        """Add a robot that is saved and whose log ends at ``done_seq``."""
        robot_id = record.robot_id

        def restarted(reason: str) -> None:
            log.warning("agent restarted", robot_id=robot_id, reason=reason)
            text = f"The agent of {robot_id} was restarted; nothing is lost."
            raised = self._alerts.raise_(
                "agent", robot_id, text, "warning", event="agent_restarted", robot_id=robot_id
            )
            self._tasks.spawn(raised)

        def in_trouble(reason: str) -> None:
            text = (
                f"The agent of {robot_id} does not start: {reason}. What {robot_id} sends is kept,"
                " and it is tried again and again."
            )
            raised = self._alerts.raise_(
                "agent", robot_id, text, "alarm", event="agent_down", robot_id=robot_id
            )
            self._tasks.spawn(raised)

        host = AgentHost(
            self._forks,
            robot_id,
            record.config,
            RobotLog(self._store, record.mission_id, robot_id),
            done_seq=done_seq,
            on_restart=restarted,
            on_trouble=in_trouble,
        )
        robot = Robot(record, host, next_seq=done_seq + 1)
        robot.stopping.order(record.stopped)
        robot.located = record.start_pose is not None
        robot.paused = self.record.state == "paused"
        self.robots[robot_id] = robot
        self.publish()
        return robot

    def publish(self, robots: Iterable[Robot] = ()) -> None:
        """Put robots, and the mission with its clock, on the board."""
        values = {}
        for robot in robots:
            values[f"robot/{robot.robot_id}"] = robot_value(robot)
            values[f"frontiers/{robot.robot_id}"] = frontiers_value(robot)
        stamps = [robot.last_stamp_s for robot in self.robots.values() if robot.last_stamp_s is not None]
        mission = {
            "mission_id": self.record.mission_id,
            "name": self.record.name,
            "state": self.record.state,
            "state_by": self.record.state_by,
            "state_unix_s": self.record.state_unix_s,
            "created_unix_s": self.record.created_unix_s,
            "started_unix_s": self.record.started_unix_s,
            "ran_s": self.record.ran_s,
            "clock_s": max(stamps, default=0.0),
            "stopped_all": self.record.stopped_all,
        }
        self._board.publish({key: value for key, value in values.items() if value is not None})
        self._board.publish({"mission": mission})

    def enter(self, record: MissionRecord) -> None:
        """Take over the mission's new state: the robots of one that is paused stand still."""
        self.record = record
        for robot in self.robots.values():
            robot.paused = record.state == "paused"
        self.publish()

    def absent(self) -> set[str]:
        """Return the robots with a log whose agents have not said anything since the server started."""
        return {name for name, robot in self.robots.items() if robot.update is None and robot.next_seq > 0}

    async def close(self) -> None:
        """End the processes of all agents."""
        await asyncio.gather(*(robot.host.close() for robot in self.robots.values()))
