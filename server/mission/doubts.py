"""Tags that are not where they were, and ways that contradict them: told to the operator once."""

from __future__ import annotations

from collections.abc import Iterable, Set

from db.records import TagRecord
from db.store import Store
from robots.team import TeamNotice
from server.mission.alerts import Alerts

_KINDS = {"moved": "tag_moved", "cloned": "tag_cloned", "doubtful": "tag_doubtful", "way": "way_doubtful"}
_SOUND = "tag_sound"
_REMEMBERED = 500  # latest events that are looked through after a restart


class Doubts:
    """What has been told of each tag and robot.

    A doubt that comes and goes while robots read more is told once, and once that it is over.
    """

    def __init__(self, store: Store, mission_id: str, alerts: Alerts) -> None:
        self._store = store
        self._mission_id = mission_id
        self._alerts = alerts
        self._told: set[tuple[str, str]] = set()  # kind of event and what it is about
        self._doubted: dict[str, str] = {}  # tag -> kind

    async def restore(self, tags: Iterable[TagRecord]) -> None:
        """Take over what had been told before a restart."""
        for tag in tags:
            if tag.state != "sound":
                about = tag.tag_id.partition("#")[0]
                self._doubted[about] = _KINDS[tag.state]
                self._told.add((_KINDS[tag.state], about))
        for event in await self._store.findings.latest_events(self._mission_id, _REMEMBERED):
            if event.kind == _KINDS["way"] and event.robot_id is not None:
                self._told.add((event.kind, event.robot_id))

    async def take(self, notices: Iterable[TeamNotice], absent: Set[str]) -> None:
        """Tell what is new; what is over only when every robot is heard, as it may lack their sightings."""
        now: dict[str, str] = {}
        for notice in notices:
            kind = _KINDS[notice.kind]
            about_way = notice.kind == "way"
            if not about_way:
                now[notice.about] = kind
            if (kind, notice.about) not in self._told:
                self._told.add((kind, notice.about))
                robot_id = notice.about if about_way else next(iter(notice.robots), None)
                tag_id = None if about_way else notice.about
                await self._alerts.raise_(
                    "tag", notice.about, notice.text, "warning", event=kind, robot_id=robot_id, tag_id=tag_id
                )
        if absent:
            self._doubted |= now
            return
        for tag in sorted(set(self._doubted) - set(now)):
            if (_SOUND, tag) not in self._told:
                self._told.add((_SOUND, tag))
                await self._alerts.end("tag", tag, f"Readings of tag {tag} agree again.", event=_SOUND)
        self._doubted = now
