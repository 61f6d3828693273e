"""The truth about slippage: where the wheels' distance is wrong.

Odometry takes the distance from the four wheels' mean and the turn from the inertial unit, so the wheels
*slip* when their mean rolls further than the base is carried along its heading, in the direction they roll,
by

    more than 0.1 m/s, and more than a quarter of what they roll, while they roll at all (0.05 m/s).

Wheels of a skid-steered robot always scrub sideways and, in turns, along: left and right against each other.
That is kinematics, not slippage: it cancels in the mean, and the label does not see it. A robot that slides
further than its wheels roll (locked wheels on ice, down a slope) is no slippage in this sense either: its
wheels already say too little, and counting their distance as zero would not help.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array, wrap_array
from robots.sim.physics.drive import Drive

SLIP_MPS = 0.10
SLIP_SHARE = 0.25
ROLLING_MPS = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class TrueMotion:
    """Between n observations: ``wheels_mps`` (n,) mean of the rims, ``base_mps`` (n,) along the heading."""

    wheels_mps: Array
    base_mps: Array

    @property
    def slips(self) -> NDArray[np.bool_]:
        """Return which of the n intervals are slippage."""
        beyond = (self.wheels_mps - self.base_mps) * np.sign(self.wheels_mps)
        rolled = np.abs(self.wheels_mps)
        labels: NDArray[np.bool_] = (
            (beyond > SLIP_MPS) & (beyond > SLIP_SHARE * rolled) & (rolled > ROLLING_MPS)
        )
        return labels


def true_motion(drive: Drive) -> TrueMotion:
    """Return what truly happened between the observations of a drive."""
    dt = np.diff(drive.stamps_s, prepend=0.0)
    moved = np.diff(drive.poses, axis=0)
    heading = drive.poses[:-1, 2] + wrap_array(moved[:, 2]) / 2.0
    along = np.cos(heading) * moved[:, 0] + np.sin(heading) * moved[:, 1]
    return TrueMotion(drive.true_rolled_m.mean(axis=1) / dt, along / dt)
