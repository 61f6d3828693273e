"""A mission while it runs: observations in, saved, thought about, saved, published, and the next order
out.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import structlog

from db.records import (
    AnnotationRecord,
    EventRecord,
    MissionRecord,
    ObservationRecord,
    RobotRecord,
    Severity,
    VictimRecord,
)
from db.store import Store
from robots import codec
from robots.agent import merged_command
from robots.tags.memory import TagMemoryError, decode_memory, merge_bytes
from robots.team import TeamGrid, TeamUpdate
from robots.types import AgentUpdate, Command, Observation
from server.agents.host import AgentHost, Answer
from server.agents.process import ForkServer, WorkerDiedError
from server.agents.team import TeamHost
from server.board import Board
from server.differences import differences
from server.errors import ApiError, unknown
from server.map_image import MapImage, draw
from server.robot import Link, Robot, RobotLog, robot_value
from server.schemas.convert import command_to_wire, pose_to_wire
from server.schemas.observations import OnboardWire
from server.settings import Settings
from server.sharing import (
    annotation_value,
    event_value,
    map_value,
    tag_record,
    tag_value,
    team_values,
    vanished,
    victim_record,
    victim_value,
)

_EVENTS_SHOWN = 50
_LINK_EVERY_S = 0.5

log = structlog.get_logger()


class Mission:
    """One mission. ``board`` is what everybody sees; ``on_grid`` is told of every new fused map."""

    def __init__(
        self,
        record: MissionRecord,
        store: Store,
        forks: ForkServer,
        settings: Settings,
        on_grid: Callable[[str, TeamGrid], None],
    ) -> None:
        self.record = record
        self.board = Board()
        self.robots: dict[str, Robot] = {}
        self.victims: dict[str, VictimRecord] = {}
        self.annotations: dict[str, AnnotationRecord] = {}
        self.image: MapImage | None = None
        self._store = store
        self._forks = forks
        self._settings = settings
        self._on_grid = on_grid
        self._grid_version: int | None = None
        self._events: list[int] = []
        self._tasks: set[asyncio.Task[Any]] = set()
        self._team = TeamHost(forks, self._take_team, name=record.mission_id)
        self._spawn(self._watch_links())
        self._publish_mission()

    @property
    def mission_id(self) -> str:
        """Its id in addresses."""
        return self.record.mission_id

    async def restore(self) -> None:
        """Bring back robots, findings and events from the database; the agents catch up in the background."""
        mission_id = self.mission_id
        for event in await self._store.findings.latest_events(mission_id, _EVENTS_SHOWN):
            self._show_event(event)
        self.victims = {v.victim_id: v for v in await self._store.findings.victims_of(mission_id)}
        self.annotations = {a.annotation_id: a for a in await self._store.findings.annotations_of(mission_id)}
        tags = await self._store.tags.tags_of(mission_id)
        self.board.publish({f"tag/{tag.tag_id}": tag_value(tag) for tag in tags})
        self.board.publish({f"victim/{v.victim_id}": victim_value(v) for v in self.victims.values()})
        self.board.publish({f"annotation/{k}": annotation_value(a) for k, a in self.annotations.items()})
        for record in await self._store.missions.robots_of(mission_id):
            last = await self._store.log.last_observation(mission_id, record.robot_id)
            robot = self._add(record, done_seq=-1 if last is None else last.seq)
            if last is not None:
                robot.last_stamp_s, robot.heard_unix_s = last.stamp_s, last.received_unix_s
                self._spawn(self._catch_up(robot))
        self._publish_mission()

    async def close(self) -> None:
        """End the processes of all agents and of the team map."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.gather(self._team.close(), *(robot.host.close() for robot in self.robots.values()))

    def robot(self, robot_id: str) -> Robot:
        """Return a robot.

        Raises:
            ApiError: there is none of that name.
        """
        if robot_id not in self.robots:
            raise unknown("robot", robot_id)
        return self.robots[robot_id]

    async def register(self, record: RobotRecord) -> tuple[Robot, bool]:
        """Add a robot, or let it join again with the same words; say whether it is new.

        Raises:
            ApiError: a robot of that name registered otherwise.
        """
        known = self.robots.get(record.robot_id)
        if known is not None:
            if known.record.registration() != record.registration():
                raise ApiError(
                    409,
                    "robot_differs",
                    f"Robot {record.robot_id!r} registered otherwise; repeat its words or take another name.",
                    "robot_id",
                )
            return known, False
        record = replace(record, stopped=self.record.stopped_all)
        robot = self._add(record, done_seq=-1)
        await self._store.missions.register_robot(record)
        await self.tell("robot_joined", f"{record.robot_id} joined the mission.", record.robot_id)
        return robot, True

    async def ingest(
        self, robot_id: str, batch: Sequence[Observation], onboard: Sequence[OnboardWire]
    ) -> dict[str, Any]:
        """Take in observations, in the order of their seq, and return the reply of the wire.

        Raises:
            ApiError: a gap, stamps that run backwards, or too much waiting already; nothing is kept then.
        """
        robot = self.robot(robot_id)
        if robot.waiting + len(batch) > self._settings.max_waiting:
            raise ApiError(
                503, "busy", f"The agent of {robot_id} is behind; send again in a second.", retry_after_s=1
            )
        robot.waiting += len(batch)
        try:
            async with robot.arriving:
                fresh = _fresh(robot, batch)
                thought = await self._accept(robot, fresh) if fresh else None
            if thought is not None:
                # a stopped robot has its STOP at once, whatever its agent is doing
                patience = self._settings.stop_reply_s if robot.stopped else None
                done, _ = await asyncio.wait({thought}, timeout=patience)
                if done and (error := thought.exception()) is not None:
                    raise error
        finally:
            robot.waiting -= len(batch)
        found = differences(robot, onboard)
        for difference in found[:1]:
            text = (
                f"{robot_id} decided otherwise on board at observation {difference['seq']}:"
                f" {difference['what']}."
            )
            await self.tell("onboard_differs", text, robot_id, "warning")
        return self._reply(robot, batch, len(fresh), found)

    async def stop(self, robot_ids: list[str] | None, stopped: bool, by: str) -> list[str]:
        """Stop robots, or let them go on; None for all. Return who is stopped now.

        Raises:
            ApiError: there is no robot of one of the names.
        """
        chosen = [self.robot(robot_id) for robot_id in robot_ids or []]
        if robot_ids is None:
            chosen = list(self.robots.values())
            self.record = replace(self.record, stopped_all=stopped)
        for robot in chosen:  # before it is saved: a full disk must not keep a robot moving
            robot.stopped = stopped
            robot.record = replace(robot.record, stopped=stopped)
        self._publish_robots(chosen)
        self._publish_mission()
        names = [robot.robot_id for robot in chosen]
        await self._store.missions.record_stop(
            self.mission_id, names, stopped=stopped, all_=robot_ids is None
        )
        who = "all robots" if robot_ids is None else ", ".join(names)
        if stopped:
            await self.tell("stop", f"STOP for {who} by {by}.", None, "warning")
        else:
            await self.tell("resume", f"{who} may go on, says {by}.".capitalize(), None)
        return sorted(robot.robot_id for robot in self.robots.values() if robot.stopped)

    async def tell(
        self, kind: str, text: str, robot_id: str | None = None, severity: Severity = "info"
    ) -> None:
        """Record an event and show it."""
        event = EventRecord(0, time.time(), kind, text, robot_id, severity)
        self._show_event(await self._store.findings.record_event(self.mission_id, event))

    async def judge_victim(self, victim_id: str, status: Any, note: str | None, by: str) -> VictimRecord:
        """Keep what a person says about a victim.

        Raises:
            ApiError: there is no such victim.
        """
        known = self.victims.get(victim_id)
        if known is None:
            raise unknown("victim", victim_id)
        victim = replace(known, status=status, note=known.note if note is None else note, by=by)
        await self._store.findings.record_status(self.mission_id, victim)
        self.victims[victim_id] = victim
        self.board.publish({f"victim/{victim_id}": victim_value(victim)})
        await self.tell("victim_judged", f"Victim {victim_id} is {status}, says {by}.")
        return victim

    async def annotate(self, annotation: AnnotationRecord) -> None:
        """Write an annotation on the map; the same id replaces the earlier one."""
        await self._store.findings.record_annotation(self.mission_id, annotation)
        self.annotations[annotation.annotation_id] = annotation
        key = f"annotation/{annotation.annotation_id}"
        self.board.publish({key: annotation_value(annotation)})

    async def unannotate(self, annotation_id: str) -> None:
        """Take an annotation off the map; it stays in the database, marked as deleted.

        Raises:
            ApiError: there is none of that id.
        """
        if annotation_id not in self.annotations:
            raise unknown("annotation", annotation_id)
        annotation = self.annotations.pop(annotation_id)
        await self._store.findings.record_annotation(self.mission_id, annotation, deleted=True)
        self.board.publish({f"annotation/{annotation_id}": None})

    async def merge_memory(self, tag_id: str, memory: bytes, by: str) -> bytes:
        """Merge bytes into what is known of a tag's memory and return the result.

        Raises:
            TagMemoryError: the bytes are no memory.
        """
        decode_memory(memory)
        return await self._store.tags.merge_memory(
            self.mission_id, tag_id, memory, merge_bytes, by=by, unix_s=time.time()
        )

    async def events_after(self, event_id: int, limit: int) -> list[EventRecord]:
        """Return events after one, oldest first."""
        return await self._store.findings.events_after(self.mission_id, event_id, limit)

    async def memory_of(self, tag_id: str) -> bytes | None:
        """Return the bytes of a tag's memory, None when nothing was ever read or written."""
        return await self._store.tags.memory_of(self.mission_id, tag_id)

    async def _accept(self, robot: Robot, fresh: list[Observation]) -> asyncio.Task[None]:
        """Save observations, and only then let the agent think about them."""
        now = time.time()
        bodies = [codec.encode(observation) for observation in fresh]
        records = [
            ObservationRecord(observation.seq, observation.stamp_s, now, body)
            for observation, body in zip(fresh, bodies, strict=True)
        ]
        await self._store.log.append_observations(self.mission_id, robot.robot_id, records)
        robot.next_seq = fresh[-1].seq + 1
        robot.last_stamp_s = fresh[-1].stamp_s
        robot.heard_unix_s, robot.heard_at_s = now, time.monotonic()
        robot.battery = next((o.battery for o in reversed(fresh) if o.battery is not None), robot.battery)
        await self._set_link(robot, "live")
        return self._spawn(self._think(robot, fresh, bodies))

    async def _think(self, robot: Robot, fresh: list[Observation], bodies: list[bytes]) -> None:
        async with robot.thinking:
            seqs = [observation.seq for observation in fresh]
            answers = await robot.host.handle(list(zip(seqs, bodies, strict=True)))
            before = robot.update
            updates = [self._take(robot, answer) for answer in answers]
            made = [update for update in updates if update is not None]
            await self._save(robot, fresh, made)
            self._publish_robots([robot])
            for update in made:
                self._team.put(robot.robot_id, update)
            await self._tell_activity(robot, before)
            self._snapshot_when_due(robot)

    def _take(self, robot: Robot, answer: Answer) -> AgentUpdate | None:
        if answer.update is None:
            log.warning("refused by the agent", robot_id=robot.robot_id, seq=answer.seq, reason=answer.reason)
            return None
        update = codec.decode(answer.update, AgentUpdate)
        robot.take(update)
        return update

    async def _save(self, robot: Robot, fresh: list[Observation], updates: list[AgentUpdate]) -> None:
        graphs = [update.graph for update in updates if update.graph is not None]
        if graphs:
            await self._store.graphs.record_graph(self.mission_id, robot.robot_id, graphs[-1])
        read = [(s.tag_id, s.memory) for observation in fresh for s in observation.tag_sightings if s.memory]
        written = [(write.tag_id, write.memory) for update in updates for write in update.command.writes]
        for tag_id, memory in [*read, *written]:
            try:
                await self.merge_memory(tag_id, memory, robot.robot_id)
            except TagMemoryError as error:
                text = f"{robot.robot_id} read tag {tag_id}, but its memory makes no sense: {error}."
                await self.tell("tag_unreadable", text, robot.robot_id, "warning")

    async def _tell_activity(self, robot: Robot, before: AgentUpdate | None) -> None:
        after = robot.update
        if after is None or before is None or after.activity == before.activity:
            return
        if after.activity == "stuck":
            await self.tell("stuck", f"{robot.robot_id} is stuck: {after.reason}.", robot.robot_id, "warning")
        if after.activity == "done":
            await self.tell("done", f"{robot.robot_id} is done: {after.reason}.", robot.robot_id)

    def _reply(
        self, robot: Robot, batch: Sequence[Observation], accepted: int, found: list[dict[str, Any]]
    ) -> dict[str, Any]:
        told = [robot.told[o.seq] for o in batch if o.seq in robot.told]
        if not told and robot.told:
            told = [next(reversed(robot.told.values()))]
        command = merged_command([item.command for item in told]) if told else Command()
        if robot.stopped:
            command = Command()
        return {
            "next_seq": robot.next_seq,
            "accepted": accepted,
            "duplicates": len(batch) - accepted,
            "stop": robot.stopped,
            "pose": pose_to_wire(told[-1].pose) if told else None,
            "command": command_to_wire(command),
            "differences": found,
        }

    def _add(self, record: RobotRecord, done_seq: int) -> Robot:
        def restarted(reason: str) -> None:
            text = f"The agent of {record.robot_id} was restarted; nothing is lost."
            log.warning("agent restarted", robot_id=record.robot_id, reason=reason)
            self._spawn(self.tell("agent_restarted", text, record.robot_id, "warning"))

        host = AgentHost(
            self._forks,
            record.robot_id,
            record.config,
            RobotLog(self._store, self.mission_id, record.robot_id),
            done_seq=done_seq,
            on_restart=restarted,
        )
        robot = Robot(record, host, next_seq=done_seq + 1, stopped=record.stopped)
        robot.located = record.start_pose is not None
        self.robots[record.robot_id] = robot
        self._team.add_robot(record.robot_id, record.start_pose)
        self._publish_mission()
        return robot

    async def _catch_up(self, robot: Robot) -> None:
        """Bring an agent back after a restart of the server and put what it knows where it was."""
        snapshot = await self._store.log.latest_snapshot(self.mission_id, robot.robot_id)
        if snapshot is not None:
            robot.recall(snapshot)
            robot.snapshot_seq = snapshot.seq
        robot.host.on_replayed = lambda answer: self._replayed(robot, answer)
        async with robot.thinking:
            report: bytes | None = None
            while report is None:
                try:
                    report = await robot.host.report()
                except WorkerDiedError:
                    await asyncio.sleep(0.2)
                    continue
                if report is None:
                    return
            update = codec.decode(report, AgentUpdate)
            robot.take(update)
            self._team.put(robot.robot_id, update)
            self._publish_robots([robot])

    def _replayed(self, robot: Robot, answer: Answer) -> None:
        if answer.update is not None:
            robot.take(codec.decode(answer.update, AgentUpdate))

    def _snapshot_when_due(self, robot: Robot) -> None:
        settings, new = self._settings, robot.host.done_seq - robot.snapshot_seq
        due = new >= settings.snapshot_every or (
            new > 0 and time.monotonic() - robot.snapshot_at_s >= settings.snapshot_every_s
        )
        if due and (robot.snapshot_task is None or robot.snapshot_task.done()):
            robot.snapshot_task = self._spawn(self._snapshot(robot))

    async def _snapshot(self, robot: Robot) -> None:
        try:
            seq, body = await robot.host.snapshot()
        except WorkerDiedError:
            return  # the next one will do
        robot.snapshot_seq, robot.snapshot_at_s = seq, time.monotonic()
        await self._store.log.record_snapshot(
            self.mission_id, robot.robot_id, robot.snapshot_record(seq, body)
        )

    async def _take_team(self, update: TeamUpdate) -> None:
        """Save and publish a new solution; everything that hangs at an anchor moves with it."""
        tags = [tag_record(tag) for tag in update.tags]
        victims = [victim_record(victim, self.victims.get(victim.victim_id)) for victim in update.victims]
        await self._store.tags.record_tags(self.mission_id, tags)
        new = [victim for victim in victims if victim.victim_id not in self.victims]
        gone = {
            victim_id
            for victim_id, victim in self.victims.items()
            if not victim.by and victim_id not in {v.victim_id for v in victims}
        }
        if victims != [self.victims.get(victim.victim_id) for victim in victims] or gone:
            await self._store.findings.record_victims(self.mission_id, victims)
            await self._store.findings.forget_victims(self.mission_id, sorted(gone))
        values: dict[str, dict[str, Any] | None] = dict(team_values(update))
        values |= vanished([v["tag_id"] for v in self.board.of_kind("tag")], [t.tag_id for t in tags], "tag")
        values |= {f"tag/{tag.tag_id}": tag_value(tag) for tag in tags}
        values |= {f"victim/{victim_id}": None for victim_id in gone}
        values |= {f"victim/{victim.victim_id}": victim_value(victim) for victim in victims}
        self.victims = {k: v for k, v in self.victims.items() if k not in gone}
        self.victims |= {victim.victim_id: victim for victim in victims}
        for member in update.robots:
            if member.robot_id in self.robots:
                robot = self.robots[member.robot_id]
                robot.anchors, robot.located = member.anchors, member.located
        if update.grid is not None and update.grid.version != self._grid_version:
            self._grid_version = update.grid.version
            self.image = await asyncio.to_thread(draw, update.grid)
            values["map"] = map_value(self.mission_id, self.image)
            self._on_grid(self.mission_id, update.grid)
        self.board.publish(values)
        self._publish_robots(self.robots.values())
        for victim in new:
            text = (
                f"Victim {victim.victim_id} seen by {', '.join(victim.robots)}, {victim.confidence:.0%} sure."
            )
            await self.tell("victim_seen", text, victim.robots[0], "alarm")

    async def _watch_links(self) -> None:
        settings = self._settings
        while True:
            await asyncio.sleep(_LINK_EVERY_S)
            for robot in list(self.robots.values()):
                silence_s = time.monotonic() - robot.heard_at_s
                if robot.update is None or robot.link == "lost":
                    continue
                if silence_s > settings.lost_after_s:
                    await self._set_link(robot, "lost")
                elif silence_s > settings.late_after_s:
                    await self._set_link(robot, "late")

    async def _set_link(self, robot: Robot, link: Link) -> None:
        before, robot.link = robot.link, link
        if before == link:
            return
        self._publish_robots([robot])
        if link == "lost":
            text = f"{robot.robot_id} is lost: nothing heard for {self._settings.lost_after_s:.0f} s."
            await self.tell("robot_lost", text, robot.robot_id, "warning")
        elif link == "live" and before == "lost" and robot.update is not None:
            await self.tell("robot_heard", f"{robot.robot_id} is heard again.", robot.robot_id)

    def _publish_robots(self, robots: Any) -> None:
        values = {f"robot/{robot.robot_id}": robot_value(robot) for robot in robots}
        self.board.publish({key: value for key, value in values.items() if value is not None})
        self._publish_mission()

    def _publish_mission(self) -> None:
        stamps = [robot.last_stamp_s for robot in self.robots.values() if robot.last_stamp_s is not None]
        self.board.publish(
            {
                "mission": {
                    "mission_id": self.mission_id,
                    "name": self.record.name,
                    "state": self.record.state,
                    "created_unix_s": self.record.created_unix_s,
                    "clock_s": max(stamps, default=0.0),
                    "stopped_all": self.record.stopped_all,
                }
            }
        )

    def _show_event(self, event: EventRecord) -> None:
        self._events.append(event.event_id)
        shown: dict[str, dict[str, Any] | None] = {f"event/{event.event_id}": event_value(event)}
        if len(self._events) > _EVENTS_SHOWN:
            shown[f"event/{self._events.pop(0)}"] = None
        self.board.publish(shown)

    def _spawn(self, work: Any) -> asyncio.Task[Any]:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            log.error("a task of the mission failed", mission_id=self.mission_id, exc_info=task.exception())


def _fresh(robot: Robot, batch: Sequence[Observation]) -> list[Observation]:
    """Return the observations that are new.

    Raises:
        ApiError: a gap, or a stamp before an earlier one.
    """
    expected, stamp = robot.next_seq, robot.last_stamp_s
    fresh: list[Observation] = []
    for place, observation in enumerate(batch):
        if observation.seq < expected:
            continue
        if observation.seq > expected:
            raise ApiError(
                409,
                "gap",
                f"Observation {observation.seq} came, but {expected} is expected next; send from next_seq {expected}.",
                f"observations.{place}.seq",
            )
        if stamp is not None and observation.stamp_s < stamp:
            raise ApiError(
                422,
                "stamp_backwards",
                f"stamp_s {observation.stamp_s} lies before {stamp} of the observation before it;"
                " a robot's clock must not run backwards.",
                f"observations.{place}.stamp_s",
            )
        fresh.append(observation)
        expected, stamp = expected + 1, observation.stamp_s
    return fresh
