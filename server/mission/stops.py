"""STOP, and letting robots go on."""

from __future__ import annotations

from dataclasses import replace

from db.errors import DatabaseError
from db.store import Store
from server.errors import ApiError
from server.mission.events import Events
from server.mission.roster import Roster


class Stops:
    """Who is stopped: decided here, put into every reply by ``replies``, saved for the next start."""

    def __init__(self, store: Store, roster: Roster, events: Events) -> None:
        self._store = store
        self._roster = roster
        self._events = events

    async def stop(self, robot_ids: list[str] | None, by: str) -> list[str]:
        """Stop robots, None for all of now and later; return who is stopped now.

        Raises:
            ApiError: there is no robot of one of the names; or STOP holds but could not be saved.
        """
        who = "all robots" if robot_ids is None else ", ".join(robot_ids)
        try:
            await self._set(robot_ids, True)
        except DatabaseError as error:
            text = (
                f"STOP holds for {who} from now on, but not after a restart of the server, since it could"
                f" not be saved: {error}"
            )
            raise ApiError(503, "stop_not_saved", text, retry_after_s=1) from error
        await self._events.tell("stop", f"STOP for {who} by {by}.", None, "warning")
        return self._stopped()

    async def resume(self, robot_ids: list[str] | None, by: str) -> list[str]:
        """Let robots go on, None for all; return who is stopped now.

        Raises:
            ApiError: there is no robot of one of the names.
            DatabaseError: they go on, but are stopped after a restart of the server.
        """
        await self._set(robot_ids, False)
        who = "All robots" if robot_ids is None else ", ".join(robot_ids)
        await self._events.tell("resume", f"{who} may go on, says {by}.")
        return self._stopped()

    async def _set(self, robot_ids: list[str] | None, stopped: bool) -> None:
        roster = self._roster
        if robot_ids is None:
            chosen = list(roster.robots.values())
            roster.record = replace(roster.record, stopped_all=stopped)
        else:
            chosen = [roster.get(robot_id) for robot_id in robot_ids]
        for robot in chosen:  # before it is saved: a full disk must not keep a robot moving
            robot.set_stopped(stopped)
        roster.publish(chosen)
        await self._store.missions.record_stop(
            roster.record.mission_id,
            [robot.robot_id for robot in chosen],
            stopped=stopped,
            all_=roster.record.stopped_all,
        )

    def _stopped(self) -> list[str]:
        return sorted(robot.robot_id for robot in self._roster.robots.values() if robot.stopped)
