"""What agents say of their robots that people have to know: stuck, slipping, short of power or of tags.

Counted in the robot's own time, the stamps of its observations, so that a mission played fast is judged like
a live one. Each alert has a lower bar to raise it and a higher one to end it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp

from robots.se2 import Pose2
from robots.types import AgentUpdate
from server.mission.alerts import Alerts
from server.mission.events import Events
from server.robot import Robot

# So often at one place, over so long: robots that wait for one another back off too, and get past.
_STUCK_TIMES, _STUCK_WITHIN_M, _STUCK_FOR_S, _STUCK_OVER_S = 3, 1.0, 30.0, 30.0
_SLIP_S, _SLIP_RAISES, _SLIP_ENDS = 10.0, 0.5, 0.1  # share of the time, averaged over so long
_BATTERY_WARNS, _BATTERY_ALARMS, _BATTERY_ENDS = 0.2, 0.1, 0.25
_TAGS_WARN, _TAGS_END = 3, 6


@dataclass(slots=True)
class _Watched:
    """What is remembered of one robot."""

    stamp_s: float | None = None
    activity: str = ""
    stuck_times: int = 0  # since it came to where it is
    stuck_at: Pose2 = field(default_factory=Pose2)  # the first of them, map frame
    stuck_since_s: float = 0.0
    last_stuck_s: float = 0.0
    slip_share: float = 0.0


class RobotAlerts:
    """Watches the robots of a mission by their latest updates."""

    def __init__(self, alerts: Alerts, events: Events) -> None:
        self._alerts = alerts
        self._events = events
        self._watched: dict[str, _Watched] = {}

    async def look(self, robot: Robot) -> None:
        """Look at a robot whose agent has just answered."""
        update = robot.update
        if update is None:
            return
        watched = self._watched.setdefault(robot.robot_id, _Watched(activity=update.activity))
        elapsed_s = 0.0 if watched.stamp_s is None else max(0.0, update.stamp_s - watched.stamp_s)
        before, watched.activity, watched.stamp_s = watched.activity, update.activity, update.stamp_s
        name = robot.robot_id
        await self._alerts.end("agent", name, f"The agent of {name} answers again.", event="agent_answers")
        if update.activity == "done" and before != "done":
            await self._events.tell("done", f"{name} is done: {update.reason}.", name)
        await self._stuck(name, watched, before, update)
        await self._slipping(name, watched, elapsed_s, update.slipping)
        await self._battery(name, robot.battery)
        await self._magazine(name, update.tags_left)

    async def _stuck(self, name: str, watched: _Watched, before: str, update: AgentUpdate) -> None:
        now_s, is_stuck = update.stamp_s, update.activity == "stuck"
        got_away = update.pose.distance(watched.stuck_at) > _STUCK_WITHIN_M
        if got_away or now_s - watched.last_stuck_s > _STUCK_OVER_S:
            watched.stuck_times = 0
        if is_stuck:
            if watched.stuck_times == 0:
                watched.stuck_at, watched.stuck_since_s = update.pose, now_s
            watched.stuck_times += before != "stuck" or watched.stuck_times == 0
            watched.last_stuck_s = now_s
        long = now_s - watched.stuck_since_s >= _STUCK_FOR_S
        if is_stuck and long and watched.stuck_times >= _STUCK_TIMES:
            text = f"{name} is stuck: {update.reason}."
            await self._alerts.raise_("stuck", name, text, "warning", event="stuck", robot_id=name)
        elif watched.stuck_times == 0:
            await self._alerts.end("stuck", name, f"{name} is free again.", event="stuck_over")

    async def _slipping(self, name: str, watched: _Watched, elapsed_s: float, slips: bool) -> None:
        keeps = exp(-elapsed_s / _SLIP_S)
        watched.slip_share = keeps * watched.slip_share + (1.0 - keeps) * slips
        if watched.slip_share > _SLIP_RAISES:
            text = f"The wheels of {name} slip: they turn more than it moves."
            await self._alerts.raise_("slipping", name, text, "warning", event="slipping", robot_id=name)
        elif watched.slip_share < _SLIP_ENDS:
            await self._alerts.end(
                "slipping", name, f"The wheels of {name} hold again.", event="slipping_over"
            )

    async def _battery(self, name: str, battery: float | None) -> None:
        if battery is None:
            return
        if battery < _BATTERY_WARNS:
            severe = battery < _BATTERY_ALARMS
            if severe or not self._alerts.is_on("battery", name):
                text = f"The battery of {name} is down to {battery:.0%}."
                await self._alerts.raise_(
                    "battery", name, text, "alarm" if severe else "warning", event="battery", robot_id=name
                )
        elif battery > _BATTERY_ENDS:
            text = f"The battery of {name} is at {battery:.0%} again."
            await self._alerts.end("battery", name, text, event="battery_over")

    async def _magazine(self, name: str, tags_left: int) -> None:
        if tags_left <= _TAGS_WARN:
            text = f"{name} has {tags_left} tags left." if tags_left else f"{name} has no tags left."
            await self._alerts.raise_("magazine", name, text, "warning", event="magazine", robot_id=name)
        elif tags_left >= _TAGS_END:
            text = f"{name} has {tags_left} tags again."
            await self._alerts.end("magazine", name, text, event="magazine_over")
