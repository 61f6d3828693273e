"""Readers of the arena's robots: which tags are read when, and where each robot believes them to be."""

from __future__ import annotations

from zlib import crc32

import numpy as np

from robots.se2 import Pose2
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.kernels import tags_in_field
from robots.sim.tags import TagField
from robots.sim.world import Mask, World
from robots.types import TagSighting

SIGHT_FROM_M = 1.0  # a reader that reaches farther stands above the floor: walls are in its way


class FieldReader:
    """One robot's reader over the tags of a world."""

    def __init__(self, config: ArenaConfig, world: World, field: TagField) -> None:
        self._config = config
        self._world = world
        self._field = field
        self._within: Mask = np.zeros(0, np.bool_)
        self._read_s: dict[int, float] = {}

    def sightings(self, before: Pose2, pose: Pose2, clock_s: float) -> tuple[TagSighting, ...]:
        """Return the tags read on the way from one place to the next, in the order they were dropped."""
        config, world = self._config, self._world
        self._within = tags_in_field(
            world.cells, world.origin_m, world.resolution_m, before.x, before.y, pose.x, pose.y,
            self._field.places_m, config.reader_m, config.reader_m >= SIGHT_FROM_M,
        )  # fmt: skip
        read = []
        for index in self._within.nonzero()[0].tolist():
            if clock_s - self._read_s.get(index, -1e9) >= config.read_every_s - 1e-9:
                self._read_s[index] = clock_s
                read.append(self._field.sighting(index))
        return tuple(read)

    def reaches(self, index: int) -> bool:
        """Return whether the tag of this index was within reach at the latest look."""
        return index < len(self._within) and bool(self._within[index])


class BelievedPlaces:
    """Where a robot believes tags to be, in its map frame: off by a constant error for each."""

    def __init__(self, field: TagField, start: Pose2, error_m: float, seed: tuple[int, ...]) -> None:
        self._field = field
        self._start = start
        self._error_m = error_m
        self._seed = seed
        self._known: dict[str, tuple[float, float]] = {}

    def learn(self, tag_id: str) -> None:
        """Note a tag that was read."""
        if tag_id in self._known:
            return
        tag = self._field.named(tag_id)
        x, y = tag.x_m - self._start.x, tag.y_m - self._start.y
        if self._error_m > 0.0:
            draws = np.random.default_rng([*self._seed, crc32(tag_id.encode())]).standard_normal(2)
            x, y = x + self._error_m * float(draws[0]), y + self._error_m * float(draws[1])
        self._known[tag_id] = (x, y)

    def of(self, tag_id: str) -> tuple[float, float] | None:
        """Return where a tag is believed, None where it was never read."""
        return self._known.get(tag_id)

    def all(self) -> list[tuple[float, float]]:
        """Return where all tags that were read are believed."""
        return list(self._known.values())
