"""Commands like those of an exploring robot: to one place after the other, at a different pace each time.

Arcs, turns on the spot, stop and go. Now and then it does not see what stands in its way and pushes against
it until it gives up and backs off.
"""

from __future__ import annotations

from math import atan2, cos, hypot

import numpy as np

from robots.config import BodyConfig
from robots.se2 import Pose2, wrap
from robots.sim.physics.floor import ARENA_M

PERIOD_S = 0.2  # between two commands, as an agent with a laser at 5 Hz decides
_TURN_ON_SPOT_RAD = 0.7
_REACHED_M = 0.3


class Driver:
    """Decides every ``PERIOD_S``; knows the true pose, which costs no realism: only commands leave it."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._body = BodyConfig()
        self._goal = (0.0, 0.0)
        self._pace_mps = 0.0
        self._gain = 2.0
        self._pause_s = 0.0
        self._stuck_s = 0.0
        self._patience_s = 2.0
        self._back_s = 0.0
        self._back = (0.0, 0.0)
        self._before = Pose2()
        self._sway_rad = 0.0  # a planned path is crooked, and the pose it starts from jumps
        self._caution = 0.0  # what is near makes it slow down
        self._choose()

    def decide(self, pose: Pose2) -> tuple[float, float]:
        """Return the speed (m/s) and turn rate (rad/s) to hold for the next period."""
        moved = pose.distance(self._before) + 0.2 * abs(wrap(pose.theta - self._before.theta))
        self._before = pose
        if self._back_s > 0.0:
            self._back_s -= PERIOD_S
            return self._back
        if self._pause_s > 0.0:
            self._pause_s -= PERIOD_S
            return 0.0, 0.0
        self._stuck_s = self._stuck_s + PERIOD_S if moved < 0.25 * PERIOD_S * self._pace_mps else 0.0
        if self._stuck_s > self._patience_s:
            return self._back_off()
        x, y = self._goal
        if hypot(x - pose.x, y - pose.y) < _REACHED_M or self._rng.random() < 0.01:
            self._choose()
        return self._towards(pose)

    def _towards(self, pose: Pose2) -> tuple[float, float]:
        sway, caution = self._rng.standard_normal(2)
        self._sway_rad = 0.7 * self._sway_rad + 0.15 * float(sway)
        self._caution = 0.8 * self._caution + 0.1 * float(caution)
        bearing = atan2(self._goal[1] - pose.y, self._goal[0] - pose.x) + self._sway_rad
        error = wrap(bearing - pose.theta)
        most = self._body.max_turn_radps
        turn = min(most, max(-most, self._gain * error))
        if abs(error) > _TURN_ON_SPOT_RAD:
            return 0.0, turn
        speed = self._pace_mps * max(0.2, cos(error)) * max(0.3, 1.0 - abs(error))
        return speed * min(1.0, max(0.2, 1.0 - abs(self._caution))), turn

    def _choose(self) -> None:
        rng = self._rng
        x, y = rng.uniform(-ARENA_M / 2.0 - 0.2, ARENA_M / 2.0 + 0.2, 2)  # also where no way leads
        self._goal = float(x), float(y)
        self._pace_mps = float(rng.uniform(0.25, self._body.max_speed_mps))
        self._gain = float(rng.uniform(1.5, 2.5))
        self._patience_s = float(rng.uniform(0.5, 3.0))
        self._pause_s = float(rng.uniform(0.4, 2.0)) if rng.random() < 0.3 else 0.0
        self._stuck_s = 0.0

    def _back_off(self) -> tuple[float, float]:
        rng = self._rng
        self._choose()
        self._pause_s = 0.0
        self._back_s = float(rng.uniform(0.6, 1.6))
        self._back = -float(rng.uniform(0.15, 0.3)), float(rng.uniform(-0.5, 0.5))
        return self._back
