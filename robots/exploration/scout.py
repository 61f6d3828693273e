"""A robot but for its senses of place: where to go, what tags say and are told, where to drop them.

Whoever knows the pose and the map steps it: an agent that estimates both, or an experiment with true poses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, inf
from zlib import crc32

import numpy as np

from robots.config import AgentConfig
from robots.exploration.aim import Decision
from robots.exploration.explorer import Explorer
from robots.exploration.strategy import AnswersTags
from robots.exploration.team.communication import Communication
from robots.exploration.told.claims import PlaceOf
from robots.exploration.told.hearsay import Hearsay
from robots.exploration.told.witness import Witness, victims_near
from robots.mapping.fused import FusedGrid
from robots.mapping.local_grid import LocalGrid
from robots.orders import RobotOrder
from robots.planning.plan_grid import PlanGrid
from robots.se2 import Pose2
from robots.tags.deployment import TagDropper
from robots.tags.map_memory import MAX_BELIEFS, TagBelief, WriterMap
from robots.tags.marks import key_of
from robots.tags.memory import WINDOWS, TagMemory, TagMemoryError
from robots.tags.sealed import close_memory, open_memory
from robots.types import FrontierReport, LaserScan, Suspect, TagSighting, TagWrite
from robots.victims import KnownVictim

_TELL_EVERY_S = 1.0


def _no_place(tag_id: str) -> tuple[float, float] | None:
    return None


@dataclass(frozen=True, slots=True, eq=False)
class Situation:
    """What a scout is told at a time, in the map frame.

    ``fused`` as drawn for the last plan, or anew where ``plan_is_due``; without ``scan`` nothing is decided.
    ``seq`` is that of the observation before this one, None at the first. ``north``: the map's x axis points
    north, so that what is told of the ground round a tag can be understood. ``tag_place`` gives where a tag
    is believed, None where unknown; ``tag_places`` all that are known; ``own_map`` the tags as measured by
    this robot, to be left in memories.
    """

    stamp_s: float
    pose: Pose2
    fused: FusedGrid
    distance_m: float
    seq: int | None = None
    north: bool = True
    scan: LaserScan | None = None
    bumper: bool = False
    held: bool = False
    battery: float | None = None  # 0..1
    tags_left: int | None = None  # in the magazine
    orders: tuple[RobotOrder, ...] = ()
    suspects: tuple[Suspect, ...] = ()  # what may be a victim
    victims: tuple[KnownVictim, ...] = ()
    read: tuple[TagSighting, ...] = ()
    heard: tuple[bytes, ...] = ()  # messages of the team
    tag_place: PlaceOf = _no_place
    tag_sd_m: float = 0.0  # of the places of the tags read now
    tag_places: Callable[[], Sequence[tuple[float, float]]] = tuple
    own_map: Callable[[], Sequence[TagBelief]] = tuple


@dataclass(frozen=True, slots=True, eq=False)
class Intent:
    """What a scout means to do: drive, drop a tag, write into those just read, tell the team.

    ``doubts`` say once each what is wrong with what it heard.
    """

    decision: Decision
    drop: bool = False
    writes: tuple[TagWrite, ...] = field(default=())
    say: bytes | None = None
    doubts: tuple[str, ...] = ()


class Scout:
    """Explores for one robot. Its draws follow from the configuration's seed and the robot's id.

    Raises:
        ConfigError: a setting of ``config`` names something that does not exist.
    """

    def __init__(self, robot_id: str, config: AgentConfig) -> None:
        self.robot_id = robot_id
        self.config = config
        own = crc32(robot_id.encode())  # robots told the same seed must not draw alike
        self._communication = Communication(robot_id, config)
        self.explorer = Explorer(config, (config.seed, own, 1), self._communication)
        self.explorer.claims.own = key_of(robot_id)
        self._dropper = TagDropper(config.deployment, config.mapping, (config.seed, own, 2))
        self._witness = Witness(robot_id, config.planning.min_frontier_m, config.planning.tag_cell_m)
        self._hearsay = Hearsay()
        self._to_tell: dict[str, None] = {}  # tags that said something since what they say was drawn
        self._local: LocalGrid | None = None
        self.decision = Decision(0.0, 0.0, "starting", "waiting for the first scan")
        self.frontiers: tuple[FrontierReport, ...] = ()
        self._frontiers_s = -inf

    @property
    def _tags_talk(self) -> bool:
        return self._communication.kind != "none"

    @property
    def tags_left(self) -> int:
        """Tags in the magazine."""
        return self._dropper.left

    @property
    def explored_m2(self) -> float:
        """Free ground in the map at the last plan."""
        return self.explorer.grids.explored_m2

    def replan(self) -> None:
        """Plan anew at the next decision: the map has moved."""
        self.explorer.replan()
        self._communication.moved()

    def plan_is_due(self, stamp_s: float) -> bool:
        """Say whether the next decision plans anew and so needs the map as it is now."""
        return self.explorer.plan_is_due(stamp_s)

    def take_frontiers(self, stamp_s: float) -> tuple[FrontierReport, ...] | None:
        """Return the edges it could go to where they changed since this was last asked, once a second."""
        frontiers = self.explorer.frontiers
        if frontiers == self.frontiers or stamp_s < self._frontiers_s + _TELL_EVERY_S:
            return None
        self.frontiers, self._frontiers_s = frontiers, stamp_s
        return frontiers

    def step(self, now: Situation) -> Intent:
        """Hear the team, decide where to go and whether to drop a tag, believe what was read and answer."""
        doubts: tuple[str, ...] = ()
        if now.seq is not None:  # from the second observation on it is known where the map points
            doubts = self._communication.hear(now.stamp_s, now.north, now.heard)
        if now.heard:
            self.explorer.homing.hear(now.pose)
        drop, say = False, None
        whole, now = now.fused, self._with_local_map(now)
        doubts += self._watch_magazine(now)
        for order in now.orders:
            self.explorer.take(order, self._dropper.left)
        if now.scan is not None:
            self.decision = self.explorer.decide(
                now.stamp_s,
                now.pose,
                now.fused,
                now.scan,
                now.bumper,
                now.held,
                now.tag_place,
                battery=now.battery,
                suspects=now.suspects,
            )
            drop = self._drop(now)
            busy = self.decision.activity in ("holding", "returning", "done")
            say = self._communication.say(
                now.stamp_s, now.pose, self.decision.goal_m, whole, now.scan.range_max_m, busy
            )
        for sighting in now.read:
            self._hear(now, sighting)
        if now.read and now.tag_sd_m == 0.0:
            tags = self.explorer.claims.tags(now.tag_place, sorted(self._to_tell))
            self._hearsay.draw(tags)
            for tag in tags:
                self._to_tell.pop(tag.tag_id, None)
        return Intent(self.decision, drop, self._writes(now), say, doubts)

    def _with_local_map(self, now: Situation) -> Situation:
        """Return the same with the small map that is planned on in place of the whole, where there is one."""
        side_m, config = self.explorer.local_map_m, self.config
        if side_m == 0.0:
            self._local = None
            return now
        if self._local is None:
            self._local = LocalGrid(side_m, config.mapping, config.body.radius_m)
        if now.scan is not None:
            self._local.see(now.pose, now.scan)
            if now.bumper and self.decision.linear_mps > 0.0:
                self._local.add_felt(now.pose, config.body.radius_m, now.scan)
        return replace(now, fused=self._local)

    def _drop(self, now: Situation) -> bool:
        if now.held:
            return False
        if self.decision.drop_tag and self._dropper.drop_here(now.distance_m):
            self.explorer.errands.tag_wanted = False
            return True
        # asked at every step, where isinstance of a protocol is slow
        even_m: float = getattr(self.explorer.goals.strategy, "tag_every_m", 0.0)
        return self._dropper.should_drop(now.distance_m, now.pose, now.fused, now.tag_places(), even_m)

    def _watch_magazine(self, now: Situation) -> tuple[str, ...]:
        """See whether the tag that was to fall has fallen; return a doubt where it has not."""
        became = self._dropper.magazine(now.tags_left, now.stamp_s)
        if became == "fell":
            self.explorer.errands.tag_dropped()
        if became != "stuck":
            return ()
        self.explorer.errands.tag_stuck()
        return ("a tag was to fall and the magazine counts as many as before: look at its slider",)

    def _hear(self, now: Situation, sighting: TagSighting) -> None:
        """Believe what a tag of the mission says of the ground round it; its frame needs a compass."""
        if not now.north or not self._tags_talk:
            return
        try:
            says = open_memory(sighting.memory, sighting.tag_id, self.config.tag_memory.key_bytes)
        except TagMemoryError:
            return
        if says.trusted:
            claims, place = self.explorer.claims, now.tag_place(sighting.tag_id)
            claims.hear(sighting.tag_id, says.memory, now.stamp_s, now.tag_sd_m)
            self._to_tell[sighting.tag_id] = None
            if place is not None:
                claims.reach_m = max(claims.reach_m, hypot(place[0] - now.pose.x, place[1] - now.pose.y))

    def _writes(self, now: Situation) -> tuple[TagWrite, ...]:
        if not now.read or not self._tags_talk:
            return ()
        own = self.explorer.grids.own.of(now.fused, np.zeros((0, 3)))
        writes = (self._write(now, sighting, own) for sighting in now.read)
        return tuple(write for write in writes if write is not None)

    def _write(self, now: Situation, sighting: TagSighting, own: PlanGrid) -> TagWrite | None:
        """Leave in the tag what is known round it, and where the others are, merged with what it said."""
        tag_id, told = sighting.tag_id, self.config.tag_memory
        try:
            says = open_memory(sighting.memory, tag_id, told.key_bytes)
        except TagMemoryError:
            return None
        if not says.trusted:
            return None  # a stranger's memory is left as it is
        memory = self._answer(now, tag_id, says.memory, own).fit(told.room_bytes)
        if memory == says.memory:
            return None
        record = close_memory(memory, says.next_revision, tag_id, told.key_bytes, told.room_bytes)
        return TagWrite(tag_id, record)

    def _answer(self, now: Situation, tag_id: str, said: TagMemory, own: PlanGrid) -> TagMemory:
        told = said.merge(replace(self._told_of(now, tag_id, said, own), maps=self._map_to_leave(now)))
        goals, place = self.explorer.goals, now.tag_place(tag_id) if now.north else None
        if goals.view is not None and place is not None and isinstance(goals.strategy, AnswersTags):
            rules = goals.strategy.answer(said, goals.view, place)
            return replace(told, **{name: getattr(rules, name) for name in WINDOWS})
        return told

    def _told_of(self, now: Situation, tag_id: str, said: TagMemory, own: PlanGrid) -> TagMemory:
        """Return what is known of the ground round a tag; its frame needs a compass."""
        place = now.tag_place(tag_id) if now.north else None
        if place is None:
            return TagMemory.empty()
        trail_m, goal_m = self.explorer.trail.points, self.decision.goal_m
        heard = self._heard_of(now, place, said)
        said = said.merge(heard)
        seen = self._witness.about(tag_id, place, said, own, trail_m, goal_m, now.stamp_s)
        return heard.merge(replace(seen, victims=victims_near(now.victims, place)))

    def _heard_of(self, now: Situation, place: tuple[float, float], said: TagMemory) -> TagMemory:
        """Return what other tags said of the ground round a tag, where places are known without error."""
        if now.tag_sd_m > 0.0:
            return TagMemory.empty()
        return self._hearsay.about(place, self._witness.phase_at(place, said))

    def _map_to_leave(self, now: Situation) -> tuple[WriterMap, ...]:
        if not self.config.map_memory or now.seq is None:
            return ()
        beliefs = tuple(now.own_map()[:MAX_BELIEFS])
        return (WriterMap(self.robot_id, now.seq, beliefs),) if beliefs else ()
