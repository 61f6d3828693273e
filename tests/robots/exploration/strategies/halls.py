"""A hall to plan tours in, and what a robot sees of it."""

import numpy as np

from robots.config import PlanningConfig
from robots.exploration.settings import SafeGroundConfig
from robots.exploration.strategy import ExplorationView
from robots.exploration.told.survey import Survey
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.planning.travel import travel_costs
from robots.se2 import Pose2

SURVEY = Survey(np.ones((2, 2)), np.zeros((2, 2), np.uint8), (0.0, 0.0))
SWEEPING = PlanningConfig(safe=SafeGroundConfig(sweep=True))
CELL_M, COARSE_M, REACH_M = 0.2, 0.4, 3.0
FADES_M = 240.0


def grid_of(cells) -> PlanGrid:
    return PlanGrid(cells, np.where(cells == FREE, 5, 0).astype(np.uint8), (0.0, 0.0), CELL_M)


def hall(walls=(), columns=100) -> PlanGrid:
    """20 m by 12 m of free ground in walls."""
    cells = np.full((60, columns), FREE, np.uint8)
    for wall in (np.s_[[0, -1], :], np.s_[:, [0, -1]], *walls):
        cells[wall] = OCCUPIED
    return grid_of(cells)


def view_at(grid, x, y, trail) -> ExplorationView:
    costs = travel_costs(grid, *grid.cell_of(x, y))
    rows = np.array([(*point, 0.0, 0.0) for point in trail])
    return ExplorationView(
        Pose2(x, y), (), lambda: SURVEY, grid=grid, costs=costs, trail=rows, settings=SWEEPING
    )
