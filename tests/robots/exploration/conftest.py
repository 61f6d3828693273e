"""A robot that drives exactly as it decides, in a map that is known already."""

from collections.abc import Callable

import numpy as np
import pytest

from robots.config import AgentConfig, PlanningConfig
from robots.exploration.aim import Decision
from robots.exploration.explorer import Explorer
from robots.mapping.fused import FusedGrid
from robots.se2 import Pose2

FREE, WALL, PERIOD_S = -20, 40, 0.2


Box = tuple[float, float, float, float]  # x, y of two corners


def hall(
    width_m: float = 20.0,
    known_to_m: float | None = None,
    walls: tuple[Box, ...] = (),
    unseen: tuple[Box, ...] = (),
) -> FusedGrid:
    """A walled hall of ``width_m`` by 6 m, seen up to some x; (0, 0) lies a metre and a half into it."""
    cells = np.full((120, round(width_m / 0.05)), FREE, np.int16)
    if known_to_m is not None:
        cells[:, round((known_to_m + 1.5) / 0.05) :] = 0
    for boxes, value in ((unseen, 0), (walls, WALL)):
        for box in boxes:
            x0, y0, x1, y1 = (round((side + 1.5) / 0.05) for side in box)
            cells[y0:y1, x0:x1] = value
    cells[:2] = cells[-2:] = cells[:, :2] = WALL
    if known_to_m is None:
        cells[:, -2:] = WALL
    fused = FusedGrid(0.05)
    fused.put("hall", 0, Pose2(-1.5, -1.5), cells)
    return fused


class Rover:
    """Steps an explorer. ``battery`` falls by ``use_per_m`` for each metre; ``seen`` keeps all decisions.

    ``tags``: where tags lie.
    """

    def __init__(self, fused: FusedGrid, pose: Pose2, **planning: float) -> None:
        self.explorer = Explorer(AgentConfig(planning=PlanningConfig(explore="nearest", **planning)))
        self.fused, self.pose = fused, pose
        self.now_s, self.battery, self.use_per_m = 0.0, None, 0.0
        self.seen: list[Decision] = []
        self.tags: dict[str, tuple[float, float]] = {}

    def drive(
        self, seconds: float, until: Callable[[Decision], bool] = lambda _: False, suspects=lambda rover: ()
    ) -> Decision:
        """Drive so long, or until something is decided; return the last decision."""
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            decision = self.explorer.decide(
                self.now_s,
                self.pose,
                self.fused,
                None,
                False,
                False,
                self.tags.get,
                battery=self.battery,
                suspects=suspects(self),
            )
            self.seen.append(decision)
            if until(decision):
                break
            step = np.array([decision.linear_mps, 0.0, decision.angular_radps]) * PERIOD_S
            self.pose = self.pose @ Pose2.exp(step)
            self.now_s += PERIOD_S
            if self.battery is not None and self.use_per_m > 0.0:
                self.battery = max(0.0, self.battery - self.use_per_m * abs(decision.linear_mps) * PERIOD_S)
        return decision


@pytest.fixture
def rover() -> type[Rover]:
    return Rover


@pytest.fixture
def make_hall() -> Callable[..., FusedGrid]:
    return hall
