"""Messages between robots whose agents are led by the server: said by one, heard by the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robots.types import AgentUpdate, Observation
from server.mission.roster import Roster
from server.robot import Robot

_KEPT = 4  # of each sender for each hearer: a later message makes good for those before it
_MOST = 200  # for each hearer; an observation may hold 256


class Relay:
    """Carries what agents say to the next observation of every other robot, before that is logged.

    So a replay of the log hears the same. It serves robots of ``full`` communication whose agents run here;
    those with a radio, or an agent on board, bring what they heard themselves. What is on the way when the
    server ends is lost, and said again.
    """

    def __init__(self, roster: Roster) -> None:
        self._roster = roster
        self._waiting: dict[str, list[tuple[str, bytes]]] = {}

    def take(self, robot: Robot, updates: Sequence[AgentUpdate]) -> None:
        """Take what a robot's agent says."""
        said = [update.command.say for update in updates if update.command.say is not None]
        if not said or robot.communication != "full":
            return
        for other in self._roster.robots.values():
            if other is robot or not _served(other):
                continue
            waiting = self._waiting.setdefault(other.robot_id, [])
            waiting += [(robot.robot_id, message) for message in said[-_KEPT:]]
            of_robot = [k for k, (sender, _) in enumerate(waiting) if sender == robot.robot_id]
            for k in reversed(of_robot[:-_KEPT]):
                del waiting[k]
            del waiting[:-_MOST]

    def heard(self, robot: Robot, fresh: Sequence[Observation]) -> list[Observation]:
        """Return new observations of a robot with what it hears added to the first; see ``done``."""
        messages = tuple(message for _, message in self._waiting.get(robot.robot_id, ()))
        if not messages or not _served(robot):
            return list(fresh)
        return [replace(fresh[0], heard=(*fresh[0].heard, *messages)), *fresh[1:]]

    def done(self, robot: Robot, first: Observation) -> None:
        """Forget what went into an observation of a robot: it is in the log."""
        heard = set(first.heard)
        waiting = self._waiting.get(robot.robot_id, [])
        self._waiting[robot.robot_id] = [item for item in waiting if item[1] not in heard]


def _served(robot: Robot) -> bool:
    return robot.communication == "full" and robot.record.agent == "server"
