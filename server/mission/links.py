"""Whether robots are heard: live, late or lost."""

from __future__ import annotations

import asyncio
import time

from server.mission.alerts import Alerts
from server.mission.roster import Roster
from server.robot import Link, Robot
from server.settings import Settings

_LOOK_EVERY_S = 0.5


class Links:
    """Watches how long robots have been silent."""

    def __init__(self, roster: Roster, alerts: Alerts, settings: Settings) -> None:
        self._roster = roster
        self._alerts = alerts
        self._late_after_s = settings.late_after_s
        self._lost_after_s = settings.lost_after_s

    async def heard(self, robot: Robot) -> None:
        """Take note that a robot was heard just now."""
        robot.heard_unix_s, robot.heard_at_s = time.time(), time.monotonic()
        await self._set(robot, "live")

    async def watch(self) -> None:
        """Look at all robots again and again, until cancelled."""
        while True:
            await asyncio.sleep(_LOOK_EVERY_S)
            for robot in list(self._roster.robots.values()):
                silence_s = time.monotonic() - robot.heard_at_s
                if robot.update is None or robot.link == "lost":
                    continue
                if silence_s > self._lost_after_s:
                    await self._set(robot, "lost")
                elif silence_s > self._late_after_s:
                    await self._set(robot, "late")
                elif robot.is_unanswered:  # what hangs is its agent: that the robot is heard is told
                    self._roster.publish([robot])

    async def _set(self, robot: Robot, link: Link) -> None:
        before, robot.link = robot.link, link
        if before == link:
            return
        self._roster.publish([robot])
        if link == "lost":
            text = f"{robot.robot_id} is lost: nothing heard for {self._lost_after_s:.0f} s."
            await self._alerts.raise_(
                "lost", robot.robot_id, text, "warning", event="robot_lost", robot_id=robot.robot_id
            )
        elif link == "live" and before == "lost":
            text = f"{robot.robot_id} is heard again."
            await self._alerts.end("lost", robot.robot_id, text, event="robot_heard")
