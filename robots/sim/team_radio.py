"""Who of a simulated team hears whom: everybody, those in radio reach, or nobody; and a base station."""

from __future__ import annotations

from math import hypot, log10

import numpy as np

from robots.estimation.radio.walls import WALL_DB, count_walls
from robots.exploration.team.communication import SAY_EVERY_S
from robots.exploration.team.gossip import Gossip
from robots.exploration.team.team_ground import FREE
from robots.exploration.team.team_message import (
    LATTICE_CELL_M,
    TeamMessageError,
    decode_message,
    encode_message,
)
from robots.se2 import Array, Pose2
from robots.sim.scenario import ScenarioConfig, is_cut
from robots.sim.world import Mask, World

BASE = "base"  # its name in messages
_EXPONENT = 2.0  # of the path loss in the open
_NEAREST_M = 0.1  # nearer than that a signal grows no more


class TeamRadio:
    """Carries messages from one control period to the next.

    With ``full`` everybody hears everybody; with ``radio`` those whose signal gets through the walls: each of
    them takes ``WALL_DB``. The base station has the same radio, hears, keeps and passes on. Nothing gets to
    or from a robot whose radio is cut. A robot that was to be silent and speaks was told so on the way: from
    then on it has a radio.
    """

    def __init__(self, config: ScenarioConfig, world: World, base_m: tuple[float, float]) -> None:
        self._config = config
        self._world = world
        self._kinds = [config.agent_of(name).planning.communication for name in config.robot_ids]
        self._base_m = base_m
        self._station = Gossip(BASE, station=True)
        self._station_due_s = 0.0
        self._waiting: list[list[bytes]] = [[] for _ in self._kinds]

    @property
    def talks(self) -> bool:
        """Whether any robot speaks."""
        return any(kind in ("full", "radio") for kind in self._kinds)

    def say(self, index: int, message: bytes, poses: Array, clock_s: float) -> None:
        """Carry a robot's message to all who can hear it; ``poses`` (n, 3) are the true ones."""
        if self._kinds[index] not in ("full", "radio"):
            self._kinds[index] = "radio"
        if self._cut(index, clock_s):
            return
        here = (float(poses[index, 0]), float(poses[index, 1]))
        for other in range(len(self._kinds)):
            if other != index and self._hears(index, other, poses) and not self._cut(other, clock_s):
                self._waiting[other].append(message)
        if self._kinds[index] == "full" or self._in_reach(here, self._base_m):
            try:
                self._station.hear(clock_s, decode_message(message))
            except TeamMessageError:
                return  # a station has nobody to tell its doubts

    def take(self, index: int, poses: Array, clock_s: float) -> tuple[bytes, ...]:
        """Return what a robot has heard since this was last asked."""
        if not self.talks:
            return ()
        self._station_speaks(poses, clock_s)
        heard, self._waiting[index] = tuple(self._waiting[index]), []
        return heard

    def known_at_base(self, observable: Mask) -> float | None:
        """Return which share of what can be seen the base has been told of; None where nobody tells it."""
        if not self.talks:
            return None
        cells, (x, y) = self._station.ground.cells()
        rows, columns = np.nonzero(observable)
        r = self._world.resolution_m
        column = np.floor((self._world.origin_m[0] + (columns + 0.5) * r - x) / LATTICE_CELL_M).astype(int)
        row = np.floor((self._world.origin_m[1] + (rows + 0.5) * r - y) / LATTICE_CELL_M).astype(int)
        inside = (row >= 0) & (column >= 0) & (row < cells.shape[0]) & (column < cells.shape[1])
        known = int((cells[row[inside], column[inside]] == FREE).sum())
        return known / max(1, len(rows))

    def _station_speaks(self, poses: Array, clock_s: float) -> None:
        if not self._station.heard or clock_s < self._station_due_s:
            return  # a server that leads robots is their base itself
        self._station_due_s = clock_s + SAY_EVERY_S
        message = encode_message(self._station.say(clock_s, clock_s, Pose2(*self._base_m, 0.0), None))
        for index, kind in enumerate(self._kinds):
            here = (float(poses[index, 0]), float(poses[index, 1]))
            reached = kind == "full" or (kind == "radio" and self._in_reach(here, self._base_m))
            if reached and not self._cut(index, clock_s):
                self._waiting[index].append(message)

    def _hears(self, a: int, b: int, poses: Array) -> bool:
        kinds = {self._kinds[a], self._kinds[b]}
        if kinds == {"full"}:
            return True
        return kinds <= {"full", "radio"} and self._in_reach(
            (float(poses[a, 0]), float(poses[a, 1])), (float(poses[b, 0]), float(poses[b, 1]))
        )

    def _in_reach(self, a: tuple[float, float], b: tuple[float, float]) -> bool:
        away = hypot(b[0] - a[0], b[1] - a[1])
        if away > self._config.team_radio_m:
            return False
        # the signal at the range in the open is the weakest that is heard
        to_spare_db = 10.0 * _EXPONENT * log10(self._config.team_radio_m / max(away, _NEAREST_M))
        most = max(0, int(to_spare_db // WALL_DB)) + 1
        world, r = self._world, self._world.resolution_m
        (ax, ay), (bx, by) = (((x - world.origin_m[0]) / r, (y - world.origin_m[1]) / r) for x, y in (a, b))
        return bool(count_walls(world.cells, ax, ay, bx, by, most) < most)

    def _cut(self, index: int, clock_s: float) -> bool:
        name = self._config.robot_ids[index]
        return is_cut([cut for cut in self._config.radio_cuts if cut.robot_id == name], clock_s)
