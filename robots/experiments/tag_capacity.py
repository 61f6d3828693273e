"""How much a tag has to hold, in cells of which size, and how Kleiner's way does over its free parameters.

Five robots in sequence from one place, as in ``kleiner-exploration``; the gap is from no communication to one
shared map. The chip's capacity is all that there is: link, header, checksum and seal are taken off it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from robots.config import PlanningConfig
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, Options, Row, finite
from robots.experiments.exploring import Case, explore_all, maps_of
from robots.experiments.kleiner_exploration import NEAREST, READERS_M, TAG_EVERY_M, rows_of
from robots.exploration.settings import KleinerConfig
from robots.tags import memory

MAPS = (("normal", "office:589"),)
BITS = (512, 896, 1152, 2048, 4032, 7104, 8192, 65536)
CELLS_M = tuple(sorted(memory.CELLS_M))
TAUS_M = (2.0, 4.0, 8.0)
ALPHAS, BETAS = (0.5, 1.0, 2.0), (0.001, 0.01, 0.1)
_ENDS = (Case("none", NEAREST, magazine=0), Case("full", NEAREST, magazine=0, one_map=True))


def capacities(
    bits: Sequence[int] = BITS, readers_m: Sequence[float] = READERS_M, cells_m: Sequence[float] = CELLS_M
) -> list[Case]:
    """Return Waymark's strategy with every chip, cell and reader, and Kleiner's corrected one over tau."""
    cases = [
        Case(
            "waymark",
            PlanningConfig(explore="waymark", tag_cell_m=cell_m),
            reader_m=reader_m,
            tag_bits=size,
            tag_every_m=TAG_EVERY_M,
        )
        for reader_m in readers_m
        for cell_m in cells_m
        for size in bits
    ]
    return cases + [
        Case(f"kleiner, tau {tau_m:g} m", _kleiner("kleiner", cell_m, tau_m=tau_m), reader_m=reader_m)
        for reader_m in readers_m
        for cell_m in cells_m
        for tau_m in TAUS_M
    ]


def printed() -> list[Case]:
    """Return equation (7) and Algorithms 1 and 2 as printed, over alpha, beta and tau."""
    return [
        Case(
            f"alpha {alpha:g}, beta {beta:g}, tau {tau_m:g} m",
            _kleiner("kleiner-printed", alpha=alpha, printed_beta=beta, tau_m=tau_m),
        )
        for alpha in ALPHAS
        for beta in BETAS
        for tau_m in TAUS_M
    ]


def measure(options: Options, cases: Sequence[Case]) -> list[Row]:
    """Return a row per map and case, no communication and one map first.

    Raises:
        ExperimentError: a building cannot be had.
    """
    maps, all_cases = maps_of(options, MAPS), [*_ENDS, *cases]
    outcomes = explore_all(options, maps, all_cases)
    return [
        row
        for name, _ in maps
        for row in rows_of(
            name, all_cases, [[run[k] for run in outcomes[name]] for k in range(len(all_cases))]
        )
    ]


def _kleiner(explore: str, tag_cell_m: float = 1.0, **settings: float) -> PlanningConfig:
    return PlanningConfig(explore=explore, tag_cell_m=tag_cell_m, kleiner=KleinerConfig(**settings))


def _plot(rows: list[Row], path: Path) -> None:
    maps = list(dict.fromkeys(str(row["map"]) for row in rows))
    title = f"Share of the gap to full communication, {int(finite(rows[0], 'runs'))} runs"
    with plotting.figure(path, 1, len(maps), 2.0 + 6.0 * len(maps), 5.6, title, sharey=True) as axes:
        for column, name in enumerate(maps):
            panel = axes[0][column]
            here = [row for row in rows if row["map"] == name and row["method"] not in ("none", "full")]
            for at, row in enumerate(here):
                gap = finite(row, "gap_mean")
                error = [[gap - finite(row, "gap_low")], [finite(row, "gap_high") - gap]]
                colour = plotting.BLUE if finite(row, "reader_m") >= 1.0 else plotting.ORANGE
                panel.errorbar(at, gap, error, marker="o", color=colour, capsize=2)
            labels = [f"{row['method']}, {row['tag_bits']} bit, {row['cell_m']:g} m" for row in here]
            panel.set_xticks(range(len(here)), labels, rotation=90, fontsize=7)
            panel.set_title(f"{name} (orange: read within 0.3 m, blue: 4 m)")
        axes[0][0].set_ylabel("gap closed")


_COLUMNS = (
    Column("map", "map"),
    Column("method", "method"),
    Column("bits", "tag_bits", digits=0),
    Column("cell, m", "cell_m", digits=1),
    Column("reader, m", "reader_m", digits=1),
    Column("score, m²/m", "score_mean", "score_sd"),
    Column("gap closed", "gap_mean"),
    Column("from", "gap_low"),
    Column("to", "gap_high"),
    Column("tags", "tags", digits=0),
    Column("claimed falsely", "claimed_share"),
)

EXPERIMENT = Experiment(
    name="tag-capacity",
    summary="The gap closed over a tag's bits, cells, reader and Kleiner's tau, in sequence.",
    paper="Kleiner 2006, section V",
    default_runs=20,
    run=lambda options: measure(options, capacities()),
    plot=_plot,
    takes_maps=True,
    columns=_COLUMNS,
    notes=(
        "Bits of the whole chip; gap closed with its 95 % interval by bootstrap over the same buildings and"
        " starts. Cells are those of the window of covered ground round a tag.",
    ),
)

SWEEP = replace(
    EXPERIMENT,
    name="kleiner-sweep",
    summary="Kleiner's equation (7) and Algorithms 1 and 2 to the letter, over alpha, beta and tau.",
    paper="Kleiner 2006, section V, equations (6) to (8)",
    run=lambda options: measure(options, printed()),
    notes=("As printed; what is wrong with it and what the corrected form does is said in the docs.",),
)
