"""Victims that nobody here has seen, but tags tell of: left there by robots that are out of reach, or gone.

A mark says where a victim lies relative to its tag. It is shown at the tag's place with the doubt of both,
as told by that tag; where a robot's own finding lies at the same place, that is the victim, and what was told
of is merged into it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from db.records import PointRecord
from db.victim_records import SaidRecord, VictimRecord
from robots.tags.marks import VictimMark, key_of
from robots.victims import FARTHEST_M
from server.board import Board
from server.mission.victims import Victims

_TOLD = "t-"
_MARK_SD_M = 0.5  # of a place relative to a tag: two places that moved with the writer's map
_MORE_SD = 3.0


class ToldVictims:
    """What tags tell of victims in one mission."""

    def __init__(self, board: Board, victims: Victims) -> None:
        self._board = board
        self._victims = victims
        self._marks: dict[tuple[str, int], VictimMark] = {}

    async def hear(self, tag_id: str, marks: Sequence[VictimMark]) -> None:
        """Take in what a memory with the mission's seal tells of victims."""
        self._marks |= {(tag_id, mark.key): mark for mark in marks}
        if marks:
            await self.settle()

    async def settle(self) -> None:
        """Show what is told of and nobody here has found, and merge into findings what has been found."""
        for (tag_id, key), mark in sorted(self._marks.items()):
            victim = self._told(tag_id, mark)
            if victim is not None and not self._is_found(key, victim):
                await self._victims.add(victim)
            if victim is not None:
                await self._victims.move({victim.victim_id: victim.place})
        for victim in self._victims.all():
            found = self._finding_of(victim)
            if found is not None:
                await self._victims.say(victim.victim_id, {"merged_into": found.victim_id}, victim.said.by)

    def _told(self, tag_id: str, mark: VictimMark) -> VictimRecord | None:
        tag = self._board.get(f"tag/{tag_id}")
        if tag is None:  # where that is, is not known yet
            return None
        var_x, var_xy, var_y = tag["covariance"]
        doubt = _MARK_SD_M**2
        x_m, y_m = tag["x_m"] + 0.1 * mark.north_dm, tag["y_m"] + 0.1 * mark.west_dm
        place = PointRecord(x_m, y_m, var_x + doubt, var_xy, var_y + doubt)
        sure = f"{mark.confidence / 255:.0%} sure"
        note = f"Told by tag {tag_id}: a robot saw a victim {_way(mark)} of it, {sure}."
        said = SaidRecord(note=note, by=f"tag {tag_id}")
        seen_s = 60.0 * mark.seen_min
        return VictimRecord(
            f"{_TOLD}{mark.key:04x}", place, mark.confidence / 255, 0, (), seen_s, seen_s, said
        )

    def _is_found(self, key: int, told: VictimRecord) -> bool:
        known = self._victims.all()
        return any(key_of(victim.victim_id) == key for victim in known) or _same(told, known) is not None

    def _finding_of(self, victim: VictimRecord) -> VictimRecord | None:
        """Return the finding that a victim told of has turned out to be, None where it has not."""
        said = victim.said
        if not victim.victim_id.startswith(_TOLD) or said.merged_into or said.status != "suspected":
            return None
        key = int(victim.victim_id[len(_TOLD) :], 16)
        found = [other for other in self._victims.all() if other.robots and other.said.merged_into is None]
        by_name = [other for other in found if key_of(other.victim_id) == key]
        return by_name[0] if by_name else _same(victim, found)


def _same(told: VictimRecord, others: Sequence[VictimRecord]) -> VictimRecord | None:
    """Return the nearest victim that may be the one told of."""
    sd_m = max(told.place.var_x, told.place.var_y) ** 0.5
    gaps = [
        (hypot(other.place.x_m - told.place.x_m, other.place.y_m - told.place.y_m), other.victim_id, other)
        for other in others
        if other.victim_id != told.victim_id
    ]
    near = min(gaps, default=None, key=lambda gap: gap[:2])
    return near[2] if near is not None and near[0] < min(FARTHEST_M, max(1.0, _MORE_SD * sd_m)) else None


def _way(mark: VictimMark) -> str:
    north, west = 0.1 * mark.north_dm, 0.1 * mark.west_dm
    along, across = (
        "plan north" if north >= 0.0 else "plan south",
        "plan west" if west >= 0.0 else "plan east",
    )
    return f"{abs(north):.1f} m {along} and {abs(west):.1f} m {across}"
