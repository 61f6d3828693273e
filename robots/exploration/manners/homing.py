"""When to go back and where to: by the battery, by the end of the mission, or because it was ordered.

The way home is costed at every plan, so a robot leaves in time: need = reserve + 1.25 * use per metre * way.
"""

from __future__ import annotations

from math import isfinite

from robots.config import BodyConfig, PlanningConfig
from robots.exploration.aim import Aim
from robots.exploration.ground import Ground
from robots.exploration.manners.parking import parking_place
from robots.exploration.manners.shut_ways import as_far_as_it_goes, hopeful
from robots.se2 import Array, Pose2

HOME_M = 1.5  # near enough to where it started: others may stand there too
_CROWDED_M = 4.0  # and near enough where nothing nearer can be reached
_LEARNT_M = 5.0  # of driving that count as much as the configured use per metre
_SAFETY = 1.25  # ways home are longer than planned
_CHANGED = 0.05  # a battery that rises by so much was charged or changed
_HASTE = 0.5  # share of the top speed that is driven on the whole, turns and doors included
_MARGIN_S = 10.0
_BERTH_M = 0.25  # that others keep of one who stands: they see it blurred
_PARKED_M = 0.3  # near enough to where it is to stand
_JUMP_M = 0.5  # between two decisions: the map moved, not the robot


class Homing:
    """Watches battery and clock of one robot. The base is where its map began.

    ``battery`` as last heard, 0..1, None while unknown; ``contact_m`` where others were heard last.
    """

    def __init__(self, planning: PlanningConfig, body: BodyConfig) -> None:
        self._planning = planning
        self._cruise_mps = _HASTE * body.max_speed_mps
        self.battery: float | None = None
        self._begun_s: float | None = None
        self._pose: Pose2 | None = None
        self._full = 1.0  # the battery when learning began
        self._driven_m = 0.0  # since then
        self._way_m = 0.0  # back to the base, when last known
        self.contact_m: tuple[float, float] | None = None
        self._low = False
        self._apart_m = 2.0 * body.radius_m + planning.clearance_m + _BERTH_M
        self._parking_m: tuple[float, float] | None = None

    @property
    def use_per_m(self) -> float:
        """Share of the battery that a metre of driving takes, idle time included."""
        used = 0.0 if self.battery is None else max(0.0, self._full - self.battery)
        configured = self._planning.battery_per_m * _LEARNT_M
        return (configured + used) / (_LEARNT_M + self._driven_m)

    def observe(self, now_s: float, pose: Pose2, battery: float | None) -> None:
        """Take in where the robot is (map frame) and what its battery has left (0..1, None: unknown)."""
        if self._begun_s is None:
            self._begun_s = now_s
        if self._pose is not None:
            step = self._pose.distance(pose)
            self._driven_m += step if step < _JUMP_M else 0.0
            self._way_m += step
        self._pose = pose
        if battery is None or not isfinite(battery):
            return
        if self.battery is None or battery > self.battery + _CHANGED:
            self._full, self._driven_m, self._low = battery, 0.0, False
        self.battery = battery

    def hear(self, pose: Pose2) -> None:
        """Note that others were heard here (map frame): the last contact."""
        self.contact_m = pose.x, pose.y

    def due(self, now_s: float, ground: Ground) -> str | None:
        """Return why the robot has to go back now, None while it need not."""
        home = ground.nearest(0.0, 0.0, HOME_M)
        if home is not None:
            self._way_m = ground.cost_m(home)
        battery, planning = self.battery, self._planning
        if battery is not None:
            needed = planning.battery_reserve + _SAFETY * self.use_per_m * self._way_m
            self._low = self._low or battery <= needed
            if self._low:
                return f"the battery is at {100.0 * battery:.0f} %"
        if planning.mission_s > 0.0 and self._begun_s is not None:
            left_s = self._begun_s + planning.mission_s - now_s
            if left_s <= 0.0:
                return "the mission's time is over"
            if left_s <= self._way_m / self._cruise_mps + _MARGIN_S:
                return f"the mission ends in {left_s:.0f} s"
        return None

    def is_shut(self, ground: Ground) -> bool:
        """Say whether no way leads to the base or near it, where the base is on the map."""
        on_map = ground.grid.holds(*ground.grid.cell_of(0.0, 0.0))
        return on_map and ground.nearest(0.0, 0.0, _CROWDED_M) is None

    def aim(self, ground: Ground, why: str, trail: Array) -> Aim:
        """Return the way back, or a rest where it has got as near as it can.

        To the base; to where others were heard last when that is nearer and the battery does not reach home.
        Where no way leads there it goes to see whether the one it came on (``trail``, (k, 4)) is open by now.
        """
        place, name = (0.0, 0.0), "the base"
        contact = self.contact_m
        if contact is not None and self._falls_short(ground):
            at = ground.nearest(*contact, HOME_M)
            if at is not None and ground.cost_m(at) < self._way_m:
                place, name = contact, "where others were heard last"
        cell = ground.nearest(*place, _CROWDED_M)
        if cell is None:
            return _look_for_a_way(ground, place, trail, f"{why}; the way to {name} is shut for now")
        end = ground.grid.centre_of(*cell)
        if self._parking_m is None and ground.distance_m(*place) > HOME_M and ground.distance_m(*end) >= 0.3:
            path = ground.path_to(cell)
            reason = f"driving {ground.cost_m(cell):.0f} m to {name}: {why}"
            return (
                Aim("rest", "returning", why)
                if path is None
                else Aim("place", "returning", reason, end, path)
            )
        return self._park(ground, place, name, why)

    def leave(self) -> None:
        """Note that the robot is off to somewhere else."""
        self._parking_m = None

    def _park(self, ground: Ground, place: tuple[float, float], name: str, why: str) -> Aim:
        """Return the way to where it shuts no way, chosen once, or a rest there."""
        cell = None if self._parking_m is None else ground.nearest(*self._parking_m, _PARKED_M)
        if cell is None:  # none was chosen, or somebody else is there or in the way
            spot = parking_place(ground, place, (HOME_M, _CROWDED_M), self._apart_m)
            cell = spot or ground.grid.cell_of(ground.pose.x, ground.pose.y)
            self._parking_m = ground.grid.centre_of(*cell)
        end, path = ground.grid.centre_of(*cell), ground.path_to(cell)
        if path is None or ground.distance_m(*end) < _PARKED_M:
            home = ground.distance_m(*place) <= HOME_M
            where = f"I am at {name}" if home else f"as near to {name} as I can get"
            return Aim("rest", "done", f"{why}; {where}")
        return Aim("place", "returning", f"driving out of the others' way: {why}", end, path)

    def _falls_short(self, ground: Ground) -> bool:
        if ground.nearest(0.0, 0.0, _CROWDED_M) is None:
            return True
        return self.battery is not None and self.battery < self.use_per_m * self._way_m


def _look_for_a_way(ground: Ground, place: tuple[float, float], trail: Array, why: str) -> Aim:
    """Go as far towards a place as the way there goes, and look round: what shut it may have gone."""
    at = ground.grid.cell_of(*place)
    cell = as_far_as_it_goes(ground, hopeful(ground.grid, trail), at) or ground.nearest(*place, float("inf"))
    path = None if cell is None else ground.path_to(cell)
    if cell is None or path is None:
        return Aim("rest", "returning", why)
    return Aim("place", "returning", why, ground.grid.centre_of(*cell), path, looks=True)
