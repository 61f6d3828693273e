"""What is known of a robot's STOP without its agent: whether the robot has heard it, and whether it moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

from robots.types import DistanceTurn, Observation, Odometry, WheelEncoders

_ARM_M = 0.2  # at which turning on the spot moves something


@dataclass(slots=True)
class Stopping:
    """STOP of one robot, by what it sends.

    ``is_heard``: a robot sends new observations only once it has the reply to those before, so the first that
    come after a reply with STOP in it prove that STOP was heard. ``speed_mps``: by the odometry of the newest
    observation, None where it tells none.
    """

    is_ordered: bool = False
    is_heard: bool = False
    speed_mps: float | None = None
    _is_told: bool = False

    def order(self, stopped: bool) -> None:
        """Begin anew where the order changes."""
        if stopped != self.is_ordered:
            self.is_ordered, self._is_told, self.is_heard = stopped, False, False

    def tell(self) -> None:
        """Take note that a reply goes out."""
        self._is_told = self.is_ordered

    def take(self, fresh: Sequence[Observation], before_s: float | None) -> bool:
        """Take in new observations, ``before_s`` the stamp before; say whether STOP is heard just now."""
        if len(fresh) > 1:
            before_s = fresh[-2].stamp_s
        newest = fresh[-1]
        elapsed_s = 0.0 if before_s is None else newest.stamp_s - before_s
        self.speed_mps = None
        if newest.odometry is not None and elapsed_s > 0.0:
            self.speed_mps = moved_m(newest.odometry) / elapsed_s
        heard_before, self.is_heard = self.is_heard, self._is_told
        return self.is_heard and not heard_before


def moved_m(odometry: Odometry) -> float:
    """Return how far a robot moved or turned since its previous observation, in metres."""
    if isinstance(odometry, WheelEncoders):
        wheels = (odometry.front_left_m, odometry.front_right_m, odometry.rear_left_m, odometry.rear_right_m)
        return max(map(abs, wheels))
    if isinstance(odometry, DistanceTurn):
        return max(abs(odometry.distance_m), _ARM_M * abs(odometry.turn_rad))
    return max(hypot(odometry.dx_m, odometry.dy_m), _ARM_M * abs(odometry.dtheta_rad))
