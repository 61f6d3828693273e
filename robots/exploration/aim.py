"""What a robot is up to until it plans anew."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from robots.se2 import Array
from robots.types import Activity, FloatArray32


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """A way to drive, (n, 2) in the map frame, and what for.

    ``kind``: ``edge`` of the unknown, ``suspect`` (it may be a victim), ``place`` to go to, ``rest`` where
    the robot stands. ``looks``: at the end of the way to a place it turns round to see what has changed.
    """

    kind: Literal["edge", "suspect", "place", "rest"]
    activity: Activity
    reason: str
    goal_m: tuple[float, float] | None = None
    path: Array = field(default_factory=lambda: np.zeros((0, 2)))
    looks: bool = False

    @property
    def looking(self) -> str:
        """What it does at the end of the way, in words."""
        if self.kind == "suspect":
            return "looking whether what was warm is a victim"
        return "looking round at the edge of the unknown"


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """Velocities for the body, and what the robot is doing in words.

    ``goal_m`` and ``path_m`` (n, 2) in the map frame. ``drop_tag``: an operator wants one here.
    """

    linear_mps: float
    angular_radps: float
    activity: Activity
    reason: str
    goal_m: tuple[float, float] | None = None
    path_m: FloatArray32 = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    drop_tag: bool = False
