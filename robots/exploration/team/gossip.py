"""Who has which ground, and what to say so that nobody in reach misses anything for long.

Every message says up to which version its sender has each robot's ground. What somebody in reach lacks goes
into the next message, others' ground as well: robots that meet after hours exchange all they missed, and lost
messages are made good.
"""

from __future__ import annotations

from dataclasses import dataclass

from robots.exploration.team.team_ground import TeamGround
from robots.exploration.team.team_message import MAX_ROBOTS, MAX_TILES, Patch, TeamMessage
from robots.se2 import Pose2

_IN_REACH_S = 3.0  # after the last message
_SETTLED_S = 2.5  # others' ground that is known for less has probably reached everybody by itself


@dataclass(frozen=True, slots=True)
class Heard:
    """The newest message of somebody, and when it came by one's own clock."""

    at_s: float
    message: TeamMessage


class Gossip:
    """What one participant, a robot or a ``station``, knows of the team, and what it says next."""

    def __init__(self, robot_id: str, station: bool = False) -> None:
        self.robot_id = robot_id
        self.ground = TeamGround()
        self.heard: dict[str, Heard] = {}
        self._station = station
        self._number = 0
        self._known_then: list[tuple[float, dict[str, int]]] = []

    def hear(self, now_s: float, message: TeamMessage) -> str | None:
        """Take in a message; one that comes twice or late changes nothing. Return a doubt, or None."""
        if message.robot_id == self.robot_id:
            return f"somebody else of the team speaks as {self.robot_id}; give every robot a name of its own"
        if dict(message.known).get(self.robot_id, 0) > self.ground.known.get(self.robot_id, 0):
            return (
                f"{message.robot_id} speaks of ground that {self.robot_id} has yet to see; its message was"
                " put aside: use a robot's name for one robot of one mission"
            )
        last = self.heard.get(message.robot_id)
        if last is None and len(self.heard) >= MAX_ROBOTS - 1:
            return f"more than {MAX_ROBOTS} robots speak; what {message.robot_id} says is put aside"
        if last is None or message.number > last.message.number:
            self.heard[message.robot_id] = Heard(now_s, message)
        for patch in message.patches:
            known = patch.origin in self.ground.known or len(self.ground.known) < MAX_ROBOTS
            if patch.origin != self.robot_id and known and not self.ground.take(patch):
                return "there is no room for all the ground that the team tells of; the newest is left out"
        return None

    def say(
        self,
        now_s: float,
        stamp_s: float,
        pose: Pose2,
        goal_m: tuple[float, float] | None,
        busy: bool = False,
    ) -> TeamMessage:
        """Return the next message: pose, goal (x, y), both in the mission frame, what those in reach lack."""
        self._number += 1
        known = self.ground.known
        self._known_then = [then for then in self._known_then if then[0] >= now_s - 2.0 * _SETTLED_S]
        self._known_then.append((now_s, dict(known)))
        return TeamMessage(
            self.robot_id,
            self._number,
            stamp_s,
            pose,
            goal_m,
            tuple(sorted(known.items())),
            self._patches(now_s),
            self._station,
            busy,
        )

    def _patches(self, now_s: float) -> tuple[Patch, ...]:
        in_reach = [h.message for h in self.heard.values() if now_s - h.at_s <= _IN_REACH_S]
        theirs = [dict(message.known) for message in in_reach]
        if not theirs:
            return ()
        settled: dict[str, int] = {}
        for at_s, known in self._known_then:
            if at_s <= now_s - _SETTLED_S:
                settled = known
        patches, room = [], MAX_TILES
        others = sorted(set(self.ground.known) - {self.robot_id})
        for robot_id in (self.robot_id, *others):
            until = self.ground.known.get(robot_id, 0)
            if robot_id != self.robot_id:
                until = settled.get(robot_id, 0)
            lacking = [
                known.get(robot_id, 0)
                for known, message in zip(theirs, in_reach, strict=True)
                if message.robot_id != robot_id
            ]
            if not lacking:
                continue
            patch = self.ground.news(robot_id, min(lacking), until, room)
            if patch is not None:
                patches.append(patch)
                room -= len(patch.tiles)
        return tuple(patches)
