"""Tags as physical things: an id, a place, a few bits of memory.

And the magazines and readers robots carry.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array
from robots.tags.chip import Chip
from robots.tags.reader import SimulatedTag, read_tag, write_tag
from robots.types import TagSighting

BASE_TAG = "BASE"
WRITE_REACH_M = 0.4
LINK = "https://w.example/t/"  # in front of a tag's id
_REPEAT_S = 1.0  # a tag that stays under the antenna is reported so often


@dataclass(slots=True)
class Tag:
    """A tag lying on the floor; ``on``: its radio works; ``tilt_rad``: how far it leans over.

    ``records``: what it holds where it is no chip under a reader, but keeps one record whole or not at all.
    """

    tag_id: str
    x_m: float
    y_m: float
    chip: SimulatedTag | None = None
    records: bytes = b""
    on: bool = True
    tilt_rad: float = 0.0

    @property
    def memory(self) -> bytes:
        """The whole records in it, one after the other, as a reader hands them over."""
        return self.records if self.chip is None else b"".join(read_tag(self.chip).records)


class TagField:
    """All tags of a world, as chips of a kind or, without one, with ``capacity_bits`` for a record.

    What is too long for a tag is refused and changes nothing. ``version`` rises when a tag comes, goes,
    moves, or its radio is switched.
    """

    def __init__(self, capacity_bits: int, chip: Chip | None = None) -> None:
        self._capacity_bits = capacity_bits
        self._chip = chip
        self._tags: list[Tag] = []
        self._indices: dict[str, list[int]] = {}
        self._places: Array = np.zeros((0, 2))
        self._on: NDArray[np.bool_] = np.zeros(0, bool)
        self.refused_writes = 0
        self.version = 0

    @property
    def tags(self) -> tuple[Tag, ...]:
        """All tags in the order in which they were dropped."""
        return tuple(self._tags)

    @property
    def places_m(self) -> Array:
        """Where the tags lie, (m, 2), in the world frame."""
        return self._places

    @property
    def on(self) -> NDArray[np.bool_]:
        """Which tags' radios work, (m,)."""
        return self._on

    def tag(self, index: int) -> Tag:
        """Return the tag of this index."""
        return self._tags[index]

    def named(self, tag_id: str) -> Tag:
        """Return the first tag that bears an id. Raises KeyError."""
        return self._tags[self._indices[tag_id][0]]

    def sighting(self, index: int) -> TagSighting:
        """Return what a reader gets from the tag of this index: its id and memory."""
        tag = self._tags[index]
        return TagSighting(tag.tag_id, tag.memory)

    def drop(self, tag_id: str, x_m: float, y_m: float, *, twin: bool = False) -> None:
        """Lay a tag down; only a ``twin`` may bear an id that another tag has. Raises ValueError."""
        if tag_id in self._indices and not twin:
            raise ValueError(f"there is a tag {tag_id} already")
        self._indices.setdefault(tag_id, []).append(len(self._tags))
        chip = None if self._chip is None else SimulatedTag.formatted(self._chip, link_of(tag_id))
        self._tags.append(Tag(tag_id, x_m, y_m, chip))
        self._changed()

    def move(self, index: int, x_m: float, y_m: float) -> None:
        """Put a tag somewhere else."""
        self._tags[index].x_m, self._tags[index].y_m = x_m, y_m
        self._changed()

    def switch(self, index: int, on: bool) -> None:
        """Switch a tag's radio on or off."""
        self._tags[index].on = on
        self._changed()

    def write(
        self,
        tag_id: str,
        memory: bytes,
        x_m: float,
        y_m: float,
        reaches: Callable[[int], bool] = lambda index: False,
    ) -> bool:
        """Write a record into a tag from an antenna over a place, or by a radio that ``reaches`` the tag.

        Return False where the tag is out of reach or too small.
        """
        for index in self._indices.get(tag_id, ()):
            tag = self._tags[index]
            if np.hypot(tag.x_m - x_m, tag.y_m - y_m) <= WRITE_REACH_M or reaches(index):
                if self._put(tag, memory):
                    return True
                break
        self.refused_writes += 1
        return False

    def _put(self, tag: Tag, record: bytes) -> bool:
        if tag.chip is None:
            if 8 * len(record) > self._capacity_bits:
                return False
            tag.records = record
            return True
        try:
            write_tag(tag.chip, record)
        except ValueError:
            return False
        return True

    def _changed(self) -> None:
        self._places = np.array([(tag.x_m, tag.y_m) for tag in self._tags])
        self._on = np.array([tag.on for tag in self._tags])
        self.version += 1


def link_of(tag_id: str) -> str:
    """Return the address that a phone opens when it touches a tag."""
    return LINK + tag_id


class Magazine:
    """The tags one robot carries.

    Ids are the robot's own id and a number (``r1-007``): no two robots clash.
    """

    def __init__(self, robot_id: str, size: int) -> None:
        self._robot_id = robot_id
        self._dropped = 0
        self.left = size

    def take(self) -> str | None:
        """Return the id of the next tag, None when the magazine is empty."""
        if self.left == 0:
            return None
        self.left -= 1
        self._dropped += 1
        return f"{self._robot_id}-{self._dropped:03d}"


class Reader:
    """Reports a tag when it comes under the antenna, then at most once a second while it stays."""

    def __init__(self) -> None:
        self._reported_s: dict[int, float] = {}

    def sightings(self, field: TagField, under: NDArray[np.bool_], stamp_s: float) -> tuple[TagSighting, ...]:
        """Return what to report of the tags ``under``, bool (m,), the antenna in the last tick."""
        indices = [int(index) for index in np.flatnonzero(under)]
        self._reported_s = {k: s for k, s in self._reported_s.items() if k in indices}
        reported = []
        for index in indices:
            if stamp_s - self._reported_s.get(index, -_REPEAT_S) >= _REPEAT_S - 1e-9:
                self._reported_s[index] = stamp_s
                reported.append(field.sighting(index))
        return tuple(reported)
