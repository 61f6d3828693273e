"""Amigoni 2013 table 1: what is a strategy worth, and what coordination, in an office and in an open hall?

One to three robots with a laser of 20 m start far apart and drive at 0.15 m/s for 15 minutes; what counts is
the safe area, which lay within 3 m in sight of a robot. Two strategies (eq. 1 and 2) by three ways to share
out candidates, random ones, and Waymark's own, all on the same buildings and starts. The paper's robots
planned while the clock ran; here a way that is planned costs nothing, or three seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robots.config import AgentConfig, BodyConfig, DeploymentConfig, MappingConfig, PlanningConfig
from robots.experiments.amigoni_paper import PAPER_M2
from robots.experiments.amigoni_plot import draw
from robots.experiments.experiment import Column, Experiment, ExperimentError, Options, Row
from robots.experiments.exploring import maps_of
from robots.experiments.paired import effect, equivalence, two_way
from robots.experiments.parallel import in_parallel
from robots.exploration.settings import SafeGroundConfig
from robots.exploration.strategies.three_grids import three_grids
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.se2 import Array
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig, ScenarioError
from robots.sim.sensors import LaserConfig
from robots.sim.world import Mask, World, WorldError

MAPS = (("office", "office:800"), ("open", "open:1300"))
TEAMS, COSTS_S = (1, 2, 3), (0.0, 3.0)
STRATEGIES, COORDINATIONS = ("aojrf", "mcdm"), ("none", "simplified", "original")
RANDOM, WAYMARK = ("random", "random"), ("waymark", "exclusion")
MARGIN_M2 = 30.0  # strategies that differ by less are as good as each other
_SPEED_MPS, _LASER_M, _MINUTES = 0.15, 20.0, 15.0
_NEVER = 2.0  # all is seen from afar long before it is safe


@dataclass(frozen=True, slots=True)
class Cell:
    """A team with a method in a building."""

    map: str
    robots: int
    plan_cost_s: float
    explore: str
    coordinate: str
    seed: int
    minutes: float = _MINUTES

    def config(self) -> ArenaConfig:
        """Return the run. Waymark is told that ground is to be made safe: it would see most from afar."""
        # the baseline draws among the candidates of eq. (1) and evaluates none of them
        explore = "aojrf" if self.explore == "random" else self.explore
        planning = PlanningConfig(
            explore=explore,
            coordinate=self.coordinate if self.robots > 1 else "none",
            communication="full" if self.robots > 1 else "none",
            safe=SafeGroundConfig(sweep=True),
        )
        agent = AgentConfig(
            body=BodyConfig(max_speed_mps=_SPEED_MPS),
            mapping=MappingConfig(max_range_m=_LASER_M),
            planning=planning,
            deployment=DeploymentConfig(magazine=0),
        )
        scenario = ScenarioConfig(
            map=self.map,
            robots=self.robots,
            minutes=self.minutes,
            seed=self.seed,
            poses="truth",
            start="spread" if self.robots > 1 else "same",
            victims=0,
            base_tag=False,
            laser=LaserConfig(range_max_m=_LASER_M),
            agent_config=agent,
        )
        return ArenaConfig(
            scenario,
            in_order="at once",
            one_map=True,
            limit_s=60.0 * self.minutes,
            until=_NEVER,
            plan_cost_s=self.plan_cost_s,
        )


def play(cell: Cell) -> float:
    """Return the safe area in the end, in m2.

    Raises:
        ExperimentError: the building cannot be had.
    """
    try:
        config = cell.config()
        arena = Arena(config, ground_of(config.scenario))
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    arena.play()
    trails = []
    for robot in arena.robots:
        start = np.array([robot.start.x, robot.start.y, 0.0, 0.0])
        trails.append(robot.scout.explorer.trail.points + start)
    safe_m = config.scenario.agent_config.planning.safe.safe_m
    return safe_area_m2(arena.ground.world, np.concatenate(trails), arena.seen > 0, safe_m)


def safe_area_m2(world: World, trail: Array, seen: Mask, safe_m: float) -> float:
    """Return the area ``seen``, (h, w), that lies within a small range in sight of a trail (k, 4), in m2."""
    cells = np.where(world.free, FREE, OCCUPIED).astype(np.uint8)
    grid = PlanGrid(cells, cells, (float(world.origin_m[0]), float(world.origin_m[1])), world.resolution_m)
    safe = three_grids(grid, trail, safe_m).safe & seen
    return float(safe.sum()) * world.resolution_m**2


def methods_of(robots: int) -> list[tuple[str, str]]:
    """Return pairs of strategy and coordination; a robot alone has nobody to share with."""
    if robots == 1:
        return [(strategy, "none") for strategy in STRATEGIES] + [WAYMARK]
    pairs = [(strategy, coordination) for strategy in STRATEGIES for coordination in COORDINATIONS]
    return [*pairs, RANDOM, WAYMARK]


def measure(
    options: Options,
    teams: Sequence[int] = TEAMS,
    costs_s: Sequence[float] = COSTS_S,
    minutes: float = _MINUTES,
) -> list[Row]:
    """Return a row per method, then rows of the effects, for each map, team and cost of planning.

    Raises:
        ExperimentError: a building cannot be had.
    """
    maps = maps_of(options, MAPS)
    groups = [(name, spec, team, cost) for name, spec in maps for team in teams for cost in costs_s]
    seeds = [int(np.random.SeedSequence([options.seed, k]).generate_state(1)[0]) for k in range(options.runs)]
    cells = [
        Cell(spec, team, cost, explore, coordinate, seed, minutes)
        for _, spec, team, cost in groups
        for seed in seeds
        for explore, coordinate in methods_of(team)
    ]
    safe = iter(in_parallel(play, cells, options.jobs, options.progress))
    rows = []
    for name, _, team, cost in groups:
        methods = methods_of(team)
        values = np.array([[next(safe) for _ in methods] for _ in seeds]).T
        found = dict(zip(methods, values, strict=True))
        head: Row = {"map": name, "robots": team, "plan_cost_s": cost, "runs": options.runs}
        rows += [_mean_row(head, name, method, areas) for method, areas in found.items()]
        rows += effects(head, found)
    return rows


def _mean_row(head: Row, map_name: str, method: tuple[str, str], areas: Array) -> Row:
    paper = PAPER_M2.get((map_name, int(float(head["robots"] or 0)), *method), (None, None))
    return head | {
        "what": "safe area",
        "strategy": method[0],
        "coordination": method[1],
        "method": " ".join(dict.fromkeys(method)),
        "safe_m2": float(areas.mean()),
        "safe_sd_m2": float(areas.std(ddof=1)) if len(areas) > 1 else 0.0,
        "paper_m2": paper[0],
        "paper_sd_m2": paper[1],
    }


def effects(head: Row, found: dict[tuple[str, str], Array]) -> list[Row]:
    """Return what strategies and coordinations gain against each other, areas (n,) of the same runs."""
    rows = []
    coordinations = [c for c in COORDINATIONS if all((s, c) in found for s in STRATEGIES)]
    for coordination in coordinations:
        pair = found["aojrf", coordination], found["mcdm", coordination]
        row = _effect_row(head, f"mcdm - aojrf, {coordination}", *pair)
        rows.append(row | {"equivalent_p": equivalence(*pair, MARGIN_M2)})
    for strategy in STRATEGIES:
        for coordination in coordinations[1:]:
            name = f"{coordination} - none, {strategy}"
            rows.append(_effect_row(head, name, found[strategy, "none"], found[strategy, coordination]))
        if len(coordinations) > 1:
            name = f"simplified - original, {strategy}"
            rows.append(_effect_row(head, name, found[strategy, "original"], found[strategy, "simplified"]))
    best = found["mcdm", coordinations[-1]]
    row = _effect_row(head, f"waymark - mcdm {coordinations[-1]}", best, found[WAYMARK])
    rows.append(row | {"ratio": float(found[WAYMARK].mean() / best.mean())})
    if len(coordinations) > 1:
        table = np.array([[found[s, c] for c in coordinations] for s in STRATEGIES])
        names = ("strategy", "coordination", "both together")
        for name, p in zip(names, two_way(table), strict=True):
            rows.append(head | {"what": "ANOVA", "method": name, "p": p})
    return rows


def _effect_row(head: Row, name: str, first: Array, second: Array) -> Row:
    found = effect(first, second)
    return head | {
        "what": "effect",
        "method": name,
        "gain_m2": found.mean,
        "gain_low_m2": found.low,
        "gain_high_m2": found.high,
        "p": found.p,
    }


EXPERIMENT = Experiment(
    name="amigoni",
    summary="Strategies against coordination: safe area of 1 to 3 robots in office and open hall.",
    paper="Amigoni 2013, table 1",
    default_runs=30,
    run=measure,
    plot=draw,
    takes_maps=True,
    columns=(
        Column("map", "map"),
        Column("robots", "robots"),
        Column("s a way", "plan_cost_s", digits=0),
        Column("what", "what"),
        Column("method", "method"),
        Column("safe m²", "safe_m2", "safe_sd_m2", digits=0),
        Column("paper m²", "paper_m2", "paper_sd_m2", digits=0),
        Column("gain m²", "gain_m2", digits=0),
        Column("from", "gain_low_m2", digits=0),
        Column("to", "gain_high_m2", digits=0),
        Column("p", "p", digits=3),
        Column("p of equals", "equivalent_p", digits=3),
        Column("ratio", "ratio"),
    ),
    notes=(
        "Safe area: within 3 m in sight of where a robot was, after 15 minutes; mean ± deviation over the"
        " runs. All methods have the same buildings and starts: gains are paired, with 95 % intervals (t).",
        "p of equals: two one-sided tests that the strategies differ by less than 30 m². ANOVA: two factors,"
        " runs as blocks.",
        "s a way: what planning one way costs the robot that decides. By 'none' it plans as the paper's steps"
        " 1 to 4 do. Waymark floods its map once for a tour of up to 120 m and for each leg, of up to 15 m,"
        " plans anew; or when its goal changes, from itself and from robots whose ways it has to compare.",
        "The paper: five runs each, planning in real time on a machine that is not described. Not printed"
        " and chosen here: the bell of P(p) with 30 m, the battery's life, the base where a robot started.",
    ),
)
