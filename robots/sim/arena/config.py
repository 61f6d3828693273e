"""What a run of the arena is made of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Literal

from robots.config import AgentConfig, PlanningConfig
from robots.sim.scenario import ScenarioConfig, ScenarioError

Order = Literal["sequence", "at once"]

STEP_M = 0.2
_MAP_CELL_M, _PLAN_CELL_M = 0.1, 0.2
_PLAN_AT_LEAST_S = 5.0  # the arena asks for a plan when something happens


@dataclass(frozen=True, slots=True)
class ArenaConfig:
    """A scenario with true poses, in steps of ``STEP_M`` at full speed along the way that the scout plans.

    ``in_order``: all robots at once, or in sequence, each after the last is done or has driven ``budget_m``;
    the tags stay. ``one_map``: all write into one map and plan on it. ``reader_m``: tags are read so far off,
    by a plate over the floor, or from ``SIGHT_FROM_M`` on in line of sight; one that stays in reach is read
    again every ``read_every_s``; ``own_tags_only``: by the robot alone that dropped it. ``tag_error_m``:
    deviation of a tag's place as each robot believes it. ``collide``: whether robots stand in each other's
    way and view; where not, all of the same start begin at one and the same place. ``plan_cost_s``: so
    long a robot stands for every way that it plans to choose where to go. A run ends after ``limit_s``, when
    ``until`` of what can be seen was seen, or when nobody has anything left to do. The score is taken when
    the team has driven its budgets.
    """

    scenario: ScenarioConfig
    in_order: Order = "sequence"
    one_map: bool = False
    budget_m: float = inf
    limit_s: float = 3600.0
    until: float = 1.0
    reader_m: float = 0.3
    read_every_s: float = 2.0
    own_tags_only: bool = False
    tag_error_m: float = 0.0
    collide: bool = False
    plan_cost_s: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what cannot be played. Raises ScenarioError."""
        if self.scenario.poses != "truth":
            raise ScenarioError("the arena plays scenarios with poses=truth")
        if self.in_order == "sequence" and not isfinite(self.budget_m):
            raise ScenarioError("budget_m: robots in sequence need one; give the metres each may drive")
        for name in ("reader_m", "tag_error_m", "limit_s", "read_every_s", "plan_cost_s"):
            if not isfinite(getattr(self, name)) or getattr(self, name) < 0.0:
                raise ScenarioError(f"{name} has to be a finite number of 0 or more")

    @property
    def step_s(self) -> float:
        """Time that a step takes, in whole 1/1024 s, so that differences of stamps are exact."""
        return round(1024.0 * STEP_M / self.scenario.agent_config.body.max_speed_mps) / 1024.0

    def agent_of(self, robot_id: str) -> AgentConfig:
        """Return what a robot's scout is told: cells as coarse as doors allow, unless told otherwise."""
        config = self.scenario.agent_of(robot_id)
        if config.planning.cell_m == PlanningConfig().cell_m:
            config = replace(
                config,
                mapping=replace(config.mapping, resolution_m=_MAP_CELL_M),
                planning=replace(config.planning, cell_m=_PLAN_CELL_M),
            )
        planning = replace(config.planning, replan_every_s=_PLAN_AT_LEAST_S)
        return replace(config, planning=planning)
