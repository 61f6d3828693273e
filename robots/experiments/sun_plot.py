"""The plot of ``sun-table1`` and ``sun-table2``: odometry, single and multi, ours beside the paper's."""

from __future__ import annotations

from pathlib import Path

from robots.experiments import plotting
from robots.experiments.experiment import Row, finite

_KINDS = (
    ("odometry", "odometry", plotting.GREY),
    ("single", "RSLAM alone", plotting.ORANGE),
    ("multi", "RSLAM with others' maps", plotting.BLUE),
)


def draw(rows: list[Row], path: Path) -> None:
    """Draw a group of bars for each robot, and the paper's figures as marks on them."""
    with plotting.figure(
        path,
        rows=1,
        columns=1,
        width_in=9.6,
        height_in=4.2,
        title="Positioning error (Sun 2009, tables 1 and 2)",
    ) as axes:
        panel = axes[0][0]
        for offset, (kind, label, colour) in enumerate(_KINDS):
            at = [number + 0.27 * (offset - 1) for number in range(len(rows))]
            panel.bar(at, [finite(row, f"{kind}_m") for row in rows], 0.25, color=colour, label=label)
            panel.plot(
                at, [finite(row, f"paper_{kind}_m") for row in rows], linestyle="none", marker="D",
                markersize=4, color=plotting.BLACK, label="the paper's" if offset == 0 else None,
            )  # fmt: skip
        panel.set_yscale("log")
        panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        labels = [f"{row['world']}\nrobot {row['robot']}" for row in rows]
        panel.set_xticks(range(len(rows)), labels, rotation=60, fontsize=7)
        panel.set_ylabel("mean distance from the truth, m")
        panel.legend(ncols=4, loc="upper left")
