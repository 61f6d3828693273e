"""The plot of ``kleiner-slam``: errors over noise levels, a panel for each map and each thing measured."""

from __future__ import annotations

from pathlib import Path

from robots.experiments import plotting
from robots.experiments.errors import NAMES
from robots.experiments.experiment import Row, finite

_LABELS = {"trajectory": "Trajectory", "tags": "Tags", "map": "Map"}
_CORRECTIONS = (
    ("linear", "IMU", "tag graph, linear, IMU heading", plotting.BLUE, "o"),
    ("gauss-newton", "IMU", "tag graph, Gauss-Newton, IMU heading", plotting.GREEN, "s"),
    ("gauss-newton", "wheels", "tag graph, Gauss-Newton, no IMU (fig. 5)", plotting.PURPLE, "^"),
)


def draw(rows: list[Row], path: Path) -> None:
    """Draw the errors after rigid alignment, mean and deviation over the runs, on a logarithmic axis."""
    maps = list(dict.fromkeys(str(row["map"]) for row in rows))
    runs = int(finite(rows[0], "runs"))
    with plotting.figure(
        path,
        rows=len(NAMES),
        columns=len(maps),
        width_in=2.1 + 2.9 * len(maps),
        height_in=7.6,
        title=f"Correcting odometry by the tag graph (Kleiner 2006, figures 3 and 5), {runs} runs",
        sharex=True,
        sharey=True,
    ) as axes:
        for column, name in enumerate(maps):
            of_map = [row for row in rows if row["map"] == name]
            for row_index, thing in enumerate(NAMES):
                _panel(axes[row_index][column], of_map, thing)
            area_m2, tags = finite(of_map[0], "area_m2"), finite(of_map[0], "tags")
            axes[0][column].set_title(f"{name}: {area_m2:.0f} m², {tags:.0f} tags")
            axes[-1][column].set_xlabel("noise level of the wheels")
        for row_index, thing in enumerate(NAMES):
            axes[row_index][0].set_ylabel(f"{_LABELS[thing]}: RMS error, m")
        lines, labels = axes[0][0].get_legend_handles_labels()
        sheet = axes[0][0].get_figure()
        assert sheet is not None
        sheet.legend(lines, labels, loc="outside lower center", ncols=2)


def _panel(axes: plotting.Axes, rows: list[Row], thing: str) -> None:
    levels = sorted({int(finite(row, "noise_level")) for row in rows})
    with_imu = [row for row in rows if row["method"] == "linear"]
    _curve(axes, with_imu, "odometry", thing, "odometry: wheels alone", plotting.BLACK, "D", "-")
    label = "dead reckoning: wheels and IMU heading"
    _curve(axes, with_imu, "reckoning", thing, label, plotting.ORANGE, "v", "-")
    fifth = [finite(row, f"odometry_{thing}_m") / 5.0 for row in with_imu]
    axes.plot(levels, fifth, color=plotting.GREY, linestyle=":", label="odometry / 5: what is asked for")
    for method, heading, text, colour, marker in _CORRECTIONS:
        chosen = [row for row in rows if row["method"] == method and row["heading"] == heading]
        if chosen:
            _curve(axes, chosen, "corrected", thing, text, colour, marker, "-")
    axes.set_yscale("log")
    axes.set_xticks(levels)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")


def _curve(
    axes: plotting.Axes,
    rows: list[Row],
    stage: str,
    thing: str,
    label: str,
    colour: str,
    marker: str,
    style: str,
) -> None:
    levels = [int(finite(row, "noise_level")) for row in rows]
    means = [finite(row, f"{stage}_{thing}_m") for row in rows]
    deviations = [finite(row, f"{stage}_{thing}_sd_m") for row in rows]
    low = [max(mean - sd, 0.2 * mean) for mean, sd in zip(means, deviations, strict=True)]
    high = [mean + sd for mean, sd in zip(means, deviations, strict=True)]
    axes.fill_between(levels, low, high, color=colour, alpha=0.13, linewidth=0.0)
    axes.plot(levels, means, color=colour, marker=marker, linestyle=style, label=label)
