"""Kleiner 2006 section VI, exploration: does what tags say nearly reach full communication?

Five robots, from one place or spread out, one after the other or all at once: without communication, with
one map for all, with the strategy of those with tags but none dropped, and with tags. The score is the area
seen by the team per metre of way, when every robot has driven 0.1 m for each square metre of floor; the gap
is from no communication to the shared map.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from robots.config import PlanningConfig
from robots.experiments.experiment import Column, Experiment, Options, Row
from robots.experiments.exploring import (
    Case,
    Outcome,
    explore_all,
    gap_closed,
    maps_of,
    ratio_of_means,
    row_of,
)
from robots.experiments.kleiner_exploration_plot import draw
from robots.se2 import Array
from robots.sim.arena.config import Order
from robots.sim.starts import StartKind

MAPS = (("small", "office:263"), ("normal", "office:589"), ("large", "office:1240"))
STARTS: tuple[StartKind, ...] = ("same", "spread")
ORDERS: tuple[Order, ...] = ("sequence", "at once")
READERS_M = (0.3, 4.0)
TAG_ERROR_M = 0.3
TAG_EVERY_M = 1.0  # how often tags are met is the limit at 30 cm, not what they hold
NEAREST = PlanningConfig(explore="nearest", communication="none")


def measure(
    options: Options,
    starts: Sequence[StartKind] = STARTS,
    orders: Sequence[Order] = ORDERS,
    readers_m: Sequence[float] = READERS_M,
    errors_m: Sequence[float] = (0.0, TAG_ERROR_M),
    tags: PlanningConfig | None = None,
) -> list[Row]:
    """Return a row per map, start, order and method; errors of places only where robots go at once.

    Raises:
        ExperimentError: a building cannot be had.
    """
    planning = PlanningConfig(explore="waymark") if tags is None else tags
    groups = [
        [
            Case("none", NEAREST, order, start, magazine=0),
            Case("full", NEAREST, order, start, magazine=0, one_map=True),
            Case("no tags", planning, order, start, magazine=0),  # what the strategy brings without them
            *(
                Case("tags", planning, order, start, reader_m, tag_error_m=error_m, tag_every_m=TAG_EVERY_M)
                for reader_m in readers_m
                for error_m in (errors_m if order == "at once" else errors_m[:1])
            ),
        ]
        for start in starts
        for order in orders
    ]
    maps = maps_of(options, MAPS)
    cases = [case for group in groups for case in group]
    outcomes = explore_all(options, maps, cases)
    rows = []
    for name, _ in maps:
        position = 0
        for group in groups:
            runs = [[run[position + k] for run in outcomes[name]] for k in range(len(group))]
            rows += rows_of(name, group, runs)
            position += len(group)
    return rows


def rows_of(map_name: str, cases: Sequence[Case], runs: Sequence[Sequence[Outcome]]) -> list[Row]:
    """Return the rows of cases of which the first has no communication and the second full."""
    none, full = (_scores(outcomes) for outcomes in runs[:2])
    rows = []
    for case, outcomes in zip(cases, runs, strict=True):
        row = row_of(map_name, case, outcomes)
        gap, low, high = gap_closed(none, _scores(outcomes), full)
        row |= {"gap_mean": gap, "gap_low": low, "gap_high": high}
        row |= _against_full(case, outcomes, runs[1])
        rows.append(row)
    return rows


def _against_full(case: Case, outcomes: Sequence[Outcome], full: Sequence[Outcome]) -> Row:
    """Return how many times longer it took than with full communication, in the runs where both got there."""
    row: Row = {}
    for share in (50, 90, 99):
        pairs = [
            (ours, theirs)
            for a, b in zip(outcomes, full, strict=True)
            if (ours := getattr(a, f"t{share}_s")) is not None
            and (theirs := getattr(b, f"t{share}_s")) is not None
        ]
        names = f"t{share}_ratio", f"t{share}_ratio_low", f"t{share}_ratio_high"
        if case.in_order == "sequence" or not pairs:
            row |= dict.fromkeys(names)
        else:
            row |= dict(zip(names, ratio_of_means(*np.array(pairs).T), strict=True))
    return row


def _scores(outcomes: Sequence[Outcome]) -> Array:
    return np.array([outcome.score for outcome in outcomes])


def _plot(rows: list[Row], path: Path) -> None:
    draw(rows, path)


_COLUMNS = (
    Column("map", "map"),
    Column("start", "start"),
    Column("in order", "in_order"),
    Column("method", "method"),
    Column("reader, m", "reader_m", digits=1),
    Column("tag error, m", "tag_error_m", digits=1),
    Column("score, m²/m", "score_mean", "score_sd"),
    Column("gap closed", "gap_mean"),
    Column("from", "gap_low"),
    Column("to", "gap_high"),
    Column("T90, s", "t90_s", "t90_sd_s", digits=0),
    Column("x full", "t90_ratio"),
    Column("T99, s", "t99_s", "t99_sd_s", digits=0),
    Column("x full", "t99_ratio"),
    Column("got there", "t99_reached_share"),
    Column("claimed falsely", "claimed_share"),
    Column("stuck", "times_stuck"),
    Column("false ends", "false_ends"),
)
_NOTES = (
    "Score: area the team saw per metre of way, when every robot has driven 0.1 m per m² of floor; mean ±"
    " deviation over the runs. Gap closed: the share of the way from no communication to one shared map, with"
    " its 95 % interval by bootstrap over the same buildings and starts.",
    "None and full drive to the nearest frontier. T90, T99: when so much of what can be seen was seen, in the"
    " runs that got there (share in 'got there'); x full: times longer than with one shared map.",
    "Claimed falsely: of the ground nobody had seen when the score was taken, what the tags called covered."
    " Stuck: minutes without way. False ends: robots that were done though 1 m² in one piece was left.",
    "Tags of 2,048 bits with everything in them counted. The paper prints curves of one plan and no numbers.",
)

EXPERIMENT = Experiment(
    name="kleiner-exploration",
    summary="Exploring with tags against no and full communication, five robots on three maps.",
    paper="Kleiner 2006, section VI, figure 3 (c)",
    default_runs=24,
    run=measure,
    plot=_plot,
    columns=_COLUMNS,
    notes=_NOTES,
    takes_maps=True,
)
