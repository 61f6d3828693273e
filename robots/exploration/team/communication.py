"""What one robot hears of its team and tells it; ``planning.communication`` says how.

``none``: nothing, not even by tags. ``tags``: through the tags' memories alone. ``full``: everybody hears
everybody. ``radio``: those in reach hear each other. Places are shared in the mission frame, which a robot
knows from its surveyed start; a robot with a compass has its map turned like it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args, get_type_hints

import numpy as np

from robots.config import AgentConfig, PlanningConfig
from robots.exploration.coordination.team import Mate, Team
from robots.exploration.strategy import ExplorationView, Strategy
from robots.exploration.team.gossip import Gossip
from robots.exploration.team.team_ground import tiles_of
from robots.exploration.team.team_message import TeamMessageError, decode_message, encode_message
from robots.exploration.trail import Trail
from robots.mapping.fused import FusedGrid
from robots.mapping.local_grid import LocalGrid
from robots.se2 import Array, Pose2

COMMUNICATIONS: tuple[str, ...] = get_args(get_type_hints(PlanningConfig)["communication"])
SAY_EVERY_S = 1.0
MATE_FOR_S = 10.0  # a robot not heard for longer is reckoned with no more
_AROUND_M = 1.0  # beyond the laser's range: changed by driving since the last message
_ALL_EVERY = 30  # messages: in between only what lies round the robot is compared
_MOST_DOUBTS = 32


class Communication:
    """One robot's ears and mouth. Silent unless told ``full`` or ``radio`` and where the robot started."""

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self.robot_id = robot_id
        self._config = config
        self._reach_m = min(4.0, config.mapping.max_range_m)  # of the laser, until it is known
        self.kind: str = config.planning.communication
        self._gossip = Gossip(robot_id)
        self._mission_from_map: Pose2 | None = None
        self._said_s: float | None = None
        self._until_all = 0
        self._trails: dict[str, Trail] = {}  # of others, in the mission frame
        self._told: list[str] = []

    def hear(self, now_s: float, north: bool, messages: Sequence[bytes]) -> tuple[str, ...]:
        """Take in messages; return doubts, each told once. ``north``: the map's x axis points north."""
        if self.kind not in ("full", "radio"):
            return ()
        if self._mission_from_map is None:
            start = self._config.start
            if len(start) != 3:
                return self._doubt(
                    "where I started was not surveyed, so I can neither share places nor use those that"
                    " others tell; register with a start_pose"
                )
            self._mission_from_map = Pose2(start[0], start[1], 0.0 if north else start[2])
        doubts: tuple[str, ...] = ()
        for data in messages:
            try:
                message = decode_message(data)
                doubt = self._gossip.hear(now_s, message)
                if doubt is None and not message.station:
                    self._trails.setdefault(message.robot_id, Trail()).note(message.stamp_s, message.pose)
            except TeamMessageError as error:
                doubt = f"a message of the team was put aside: {error}"
            if doubt is not None:
                doubts += self._doubt(doubt)
        return doubts

    def say(
        self,
        now_s: float,
        pose: Pose2,
        goal_m: tuple[float, float] | None,
        fused: FusedGrid,
        reach_m: float,
        busy: bool = False,
    ) -> bytes | None:
        """Return the next message where one is due: pose and goal in the map frame, and ground.

        ``reach_m`` is how far the laser sees; ``busy``: others need not leave it anything to explore.
        """
        frame = self._mission_from_map
        if self.kind not in ("full", "radio"):
            return None
        if frame is None or (self._said_s is not None and now_s - self._said_s < SAY_EVERY_S):
            return None
        self._said_s, self._reach_m = now_s, min(reach_m, self._config.mapping.max_range_m)
        around_m = self._reach_m + _AROUND_M
        if self._until_all == 0:
            around_m, self._until_all = np.inf, _ALL_EVERY
        self._until_all -= 1
        centre = np.array([pose.x, pose.y])
        if not fused.shared:
            found = tiles_of(fused, frame, centre, around_m, self._config.mapping)
            self._gossip.ground.note(self._gossip.robot_id, found)
        goal = None if goal_m is None else frame.transform_point(*goal_m)
        try:
            return encode_message(self._gossip.say(now_s, now_s, frame @ pose, goal, busy))
        except TeamMessageError:  # lost beyond all bounds: there is nothing that others could use
            return None

    def moved(self) -> None:
        """Compare all ground at the next message: the map has moved."""
        self._until_all = 0

    def team(self, view: ExplorationView, strategy: Strategy, goal_m: tuple[float, float] | None) -> Team:
        """Return this robot, on its way to ``goal_m``, with the others that explore, in its map frame."""
        mates, seed = self._mates(view.now_s), self._config.seed
        return Team(self.robot_id, view, strategy, goal_m, mates, self._reach_m, seed)

    def mates_trail(self) -> Array:
        """Return where the others were when they were heard, (m, 4) as in ``Trail``, in the map frame."""
        if self._mission_from_map is None or not self._trails:
            return np.zeros((0, 4))
        points = np.concatenate([trail.points for _, trail in sorted(self._trails.items())])
        frame = self._mission_from_map.inverse()
        points[:, :2] = frame.transform(points[:, :2])
        points[:, 2] += frame.theta
        return points

    def mates_ways(self, now_s: float) -> Array:
        """Return places, (m, 3) as x, y, heading, a metre apart on others' straight ways to their goals."""
        ways = [np.zeros((0, 3))]
        for mate in self._mates(now_s):
            if mate.goal_m is not None:
                way = np.array(mate.goal_m) - (mate.pose.x, mate.pose.y)
                count = int(np.hypot(*way)) + 2
                points = np.linspace((mate.pose.x, mate.pose.y), mate.goal_m, count)
                ways.append(np.column_stack([points, np.full(count, np.arctan2(way[1], way[0]))]))
        return np.concatenate(ways)

    def _mates(self, now_s: float) -> list[Mate]:
        if self._mission_from_map is None:
            return []
        frame = self._mission_from_map.inverse()
        mates = []
        for robot_id, heard in self._gossip.heard.items():
            message = heard.message
            if message.station or message.busy or now_s - heard.at_s > MATE_FOR_S:
                continue
            goal = None if message.goal_m is None else frame.transform_point(*message.goal_m)
            mates.append(Mate(robot_id, frame @ message.pose, goal))
        return mates

    def overlaid(self, fused: FusedGrid) -> FusedGrid:
        """Return the map with what the team has seen where this robot knows nothing itself.

        A small map that goes along with the robot stays as it is.
        """
        if self._mission_from_map is None or isinstance(fused, LocalGrid) or fused.shared:
            return fused
        config = self._config
        factor = max(1, round(config.planning.cell_m / fused.resolution_m))
        return self._gossip.ground.overlaid(fused, factor, self._mission_from_map, config.mapping)

    def _doubt(self, text: str) -> tuple[str, ...]:
        if text in self._told or len(self._told) >= _MOST_DOUBTS:
            return ()
        self._told.append(text)
        return (text,)
