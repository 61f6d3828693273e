"""Tags as physical things: an id, a place, a few bits of memory.

And the magazines and readers robots carry.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array
from robots.types import TagSighting

BASE_TAG = "BASE"
WRITE_REACH_M = 0.4
_REPEAT_S = 1.0  # a tag that stays under the antenna is reported so often


@dataclass(slots=True)
class Tag:
    """A tag lying on the floor."""

    tag_id: str
    x_m: float
    y_m: float
    memory: bytes = b""


class TagField:
    """All tags of a world. A tag holds ``capacity_bits``; a longer write is refused and changes nothing."""

    def __init__(self, capacity_bits: int) -> None:
        self._capacity_bits = capacity_bits
        self._tags: list[Tag] = []
        self._index: dict[str, int] = {}
        self._places: Array = np.zeros((0, 2))
        self.refused_writes = 0

    @property
    def tags(self) -> tuple[Tag, ...]:
        """All tags in the order in which they were dropped."""
        return tuple(self._tags)

    @property
    def places_m(self) -> Array:
        """Where the tags lie, (m, 2), in the world frame."""
        return self._places

    def sighting(self, index: int) -> TagSighting:
        """Return what a reader gets from the tag of this index: its id and memory."""
        tag = self._tags[index]
        return TagSighting(tag.tag_id, tag.memory)

    def drop(self, tag_id: str, x_m: float, y_m: float) -> None:
        """Lay a tag down. Raises ValueError when the id is taken."""
        if tag_id in self._index:
            raise ValueError(f"there is a tag {tag_id} already")
        self._index[tag_id] = len(self._tags)
        self._tags.append(Tag(tag_id, x_m, y_m))
        self._places = np.array([(tag.x_m, tag.y_m) for tag in self._tags])

    def write(self, tag_id: str, memory: bytes, x_m: float, y_m: float) -> bool:
        """Write a tag's memory from an antenna at a place.

        Return False where the tag is out of reach or too small.
        """
        index = self._index.get(tag_id)
        if index is not None and 8 * len(memory) <= self._capacity_bits:
            tag = self._tags[index]
            if np.hypot(tag.x_m - x_m, tag.y_m - y_m) <= WRITE_REACH_M:
                tag.memory = memory
                return True
        self.refused_writes += 1
        return False


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
