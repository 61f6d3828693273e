"""The plan grids of a robot's own map, and of that with what the team has told it."""

from __future__ import annotations

from robots.config import AgentConfig
from robots.exploration.team.communication import Communication
from robots.mapping.fused import FusedGrid
from robots.planning.plan_grid import FREE, PlanGrid, PlanGrids
from robots.se2 import Array


class SharedGrids:
    """``own``: of the robot's own map alone; ``explored_m2``: free ground in it at the last plan."""

    def __init__(self, config: AgentConfig, communication: Communication) -> None:
        self.own = PlanGrids(config.body, config.planning, config.mapping)
        self.explored_m2 = 0.0
        self._shared = PlanGrids(config.body, config.planning, config.mapping)
        self._communication = communication

    def of(self, fused: FusedGrid, blocked: Array) -> PlanGrid:
        """Return the grid to plan on; ``blocked`` (n, 3): x, y, radius of places put aside."""
        grid, known = self.own.of(fused, blocked), self._communication.overlaid(fused)
        self.explored_m2 = float((grid.cells == FREE).sum()) * grid.cell_m**2
        return grid if known is fused else self._shared.of(known, blocked)
