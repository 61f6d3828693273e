"""What happens to tags that are in place when a mission begins, and what active nodes measure meanwhile."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, hypot, pi, sin
from typing import Literal

import numpy as np

from robots.se2 import Array
from robots.sim.hostile import HostileConfig
from robots.sim.starts import place_tags
from robots.sim.tags import Tag, TagField
from robots.sim.world import World
from robots.types import NodeSensors

_AMBIENT_C, _AMBIENT_HPA, _WEATHER_HPA = 18.0, 1013.0, 0.5
_FIRE_C, _FIRE_HPA = 400.0, 5.0  # at its middle and height; a hot closed room is under pressure
_FIRE_GROWS_S = 60.0
_TEMPERATURE_SD_C, _PRESSURE_SD_HPA, _TILT_SD_RAD = 0.2, 0.1, 0.01

_Change = Literal["off", "on", "move", "tilt"]


@dataclass(frozen=True, slots=True)
class Fire:
    """A fire that starts at a time and grows; ``radius_m``: where it is a third as hot as in its middle."""

    x_m: float
    y_m: float
    start_s: float
    radius_m: float

    def strength(self, x_m: float, y_m: float, clock_s: float) -> float:
        """Return how much of it is felt at a place, 0..1."""
        if clock_s <= self.start_s:
            return 0.0
        grown = 1.0 - exp(-(clock_s - self.start_s) / _FIRE_GROWS_S)
        return grown * exp(-((hypot(x_m - self.x_m, y_m - self.y_m) / self.radius_m) ** 2))


@dataclass(frozen=True, slots=True)
class _Event:
    clock_s: float
    change: _Change
    index: int
    to_m: tuple[float, float] = (0.0, 0.0)
    tilt_rad: float = 0.0


class NodeLife:
    """Lays the tags in place, and then lets happen what the scenario has in store for them.

    Nobody is told: a dead node is never heard, one switched off falls silent in the first two thirds of the
    mission and comes back, one carried off or knocked over is so from one moment to the next.
    """

    def __init__(
        self,
        world: World,
        field: TagField,
        places_m: Array,
        hostile: HostileConfig,
        radius_m: float,
        length_s: float,
        rng: np.random.Generator,
    ) -> None:
        """Lay the tags down at ``places_m``, (m, 2). Raises WorldError when the world has no room."""
        self._field = field
        base = len(field.tags)
        count = len(places_m)
        for number, (x, y) in enumerate(places_m.tolist(), 1):
            field.drop(f"N{number:02d}", x, y)
        dead, switched, moved, knocked, twins, fires = rng.spawn(6)
        self._dead = frozenset(self._some(dead, base, count, hostile.dead_tags))
        for index in self._dead:
            field.switch(index, False)
        events = []
        for index in self._some(switched, base, count, hostile.switched_tags):
            off_s = switched.uniform(0.1, 0.5) * length_s
            events.append(_Event(off_s, "off", index))
            events.append(_Event(off_s + switched.uniform(0.1, 0.3) * length_s, "on", index))
        for index in self._some(moved, base, count, hostile.moved_tags):
            x, y = place_tags(world, 2, radius_m, moved)[1].tolist()
            events.append(_Event(moved.uniform(0.2, 0.6) * length_s, "move", index, (x, y)))
        for index in self._some(knocked, base, count, hostile.knocked_tags):
            tilt = knocked.uniform(0.35 * pi, 0.5 * pi)
            events.append(_Event(knocked.uniform(0.1, 0.6) * length_s, "tilt", index, tilt_rad=tilt))
        for index in self._some(twins, base, count, hostile.twin_tags):
            x, y = place_tags(world, 2, radius_m, twins)[1].tolist()
            field.drop(field.tag(index).tag_id, x, y, twin=True)
        self._events = sorted(events, key=lambda event: (event.clock_s, event.index))
        self.fires = tuple(_fire(world, radius_m, length_s, fires) for _ in range(hostile.fires))

    def advance(self, clock_s: float) -> None:
        """Let everything happen that is due."""
        while self._events and self._events[0].clock_s <= clock_s:
            event = self._events.pop(0)
            if event.change == "move":
                self._field.move(event.index, *event.to_m)
            elif event.change == "tilt":
                self._field.tag(event.index).tilt_rad = event.tilt_rad
            elif event.index not in self._dead:
                self._field.switch(event.index, event.change == "on")

    def sensors(self, tag: Tag, clock_s: float, rng: np.random.Generator) -> NodeSensors:
        """Return what an active node measures of its own place."""
        noise = rng.standard_normal(3)
        strength = max((fire.strength(tag.x_m, tag.y_m, clock_s) for fire in self.fires), default=0.0)
        weather = _WEATHER_HPA * sin(2.0 * pi * clock_s / 3600.0)
        return NodeSensors(
            temperature_c=round(_AMBIENT_C + _FIRE_C * strength + _TEMPERATURE_SD_C * noise[0], 1),
            pressure_hpa=round(
                _AMBIENT_HPA + weather + _FIRE_HPA * strength + _PRESSURE_SD_HPA * noise[1], 1
            ),
            tilt_rad=round(abs(tag.tilt_rad + _TILT_SD_RAD * noise[2]), 3),
        )

    @staticmethod
    def _some(rng: np.random.Generator, base: int, count: int, wanted: int) -> list[int]:
        """Return the indices of some of the tags in place."""
        return [base + int(k) for k in rng.permutation(count)[:wanted]]


def _fire(world: World, radius_m: float, length_s: float, rng: np.random.Generator) -> Fire:
    x, y = place_tags(world, 1, radius_m, rng)[0].tolist()
    return Fire(x, y, rng.uniform(0.0, 0.4) * length_s, rng.uniform(2.0, 4.0))
