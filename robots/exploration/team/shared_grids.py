"""The plan grids of a robot's own map, and of that with what the team has told it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from scipy import ndimage

from robots.config import AgentConfig
from robots.exploration.ground import Ground
from robots.exploration.manners.shut_ways import squeezed
from robots.exploration.team.communication import Communication
from robots.mapping.fused import FusedGrid
from robots.planning.plan_grid import FREE, PlanGrid, PlanGrids
from robots.planning.travel import UNREACHED
from robots.se2 import Array

_AWAY = 3  # cells


class SharedGrids:
    """``own``: of the robot's own map alone; ``explored_m2``: free ground in it at the last plan."""

    def __init__(self, config: AgentConfig, communication: Communication) -> None:
        self.own = PlanGrids(config.body, config.planning, config.mapping)
        self.explored_m2 = 0.0
        self._shared = PlanGrids(config.body, config.planning, config.mapping)
        narrowly = replace(
            config.planning, cell_m=config.mapping.resolution_m, clearance_m=config.planning.clearance_m / 2.0
        )
        self._narrow = PlanGrids(config.body, narrowly, config.mapping)
        self._communication = communication

    def of(self, fused: FusedGrid, blocked: Array) -> PlanGrid:
        """Return the grid to plan on; ``blocked`` (n, 3): x, y, radius of places put aside."""
        grid, known = self.own.of(fused, blocked), self._communication.overlaid(fused)
        self.explored_m2 = float((grid.cells == FREE).sum()) * grid.cell_m**2
        return grid if known is fused else self._shared.of(known, blocked)

    def narrower(self, ground: Ground, fused: FusedGrid, blocked: Array, trail: Array) -> Iterator[Ground]:
        """Give the ground of a plan with ways that are narrower: where the robot drove before, then all gaps.

        The last is in the map's own cells, with half of the room to obstacles: of cells as large as those of
        ``of`` a door hardly wider than the body may have none in its middle. It is given where it leads
        somewhere else. ``trail`` as in ``squeezed``.
        """
        wide = squeezed(ground, trail)
        yield wide
        grid = self._narrow.of(self._communication.overlaid(fused), blocked)
        narrow = squeezed(Ground.of(grid, ground.pose), trail)
        if _leads_on(narrow, wide):
            yield narrow


def _leads_on(narrow: Ground, wide: Ground) -> bool:
    """Say whether ground can be reached that lies away from all that can be reached on wide ways."""
    factor = round(wide.grid.cell_m / narrow.grid.cell_m)
    near = ndimage.binary_dilation(wide.costs != UNREACHED, iterations=_AWAY)
    near = near.repeat(factor, axis=0).repeat(factor, axis=1)
    rows, columns = (min(*sides) for sides in zip(near.shape, narrow.costs.shape, strict=True))
    reached = narrow.costs[:rows, :columns] != UNREACHED
    return bool((reached & ~near[:rows, :columns]).any())
