"""The plot of ``kleiner-exploration``: scores in sequence, times at once, a column for each map."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from robots.experiments import plotting
from robots.experiments.experiment import Row, finite

if TYPE_CHECKING:
    from robots.experiments.plotting import Axes

_COLOURS = {"none": plotting.GREY, "full": plotting.BLACK, "no tags": plotting.SKY}
_TAGS = (plotting.ORANGE, plotting.BLUE, plotting.GREEN, plotting.PURPLE)
_TIMES = (("t50", "50 %"), ("t90", "90 %"), ("t99", "99 %"))


def draw(rows: list[Row], path: Path) -> None:
    """Draw scores with deviations, and when 50, 90 and 99 % of what can be seen were seen."""
    maps = list(dict.fromkeys(str(row["map"]) for row in rows))
    starts = list(dict.fromkeys(str(row["start"]) for row in rows))
    with plotting.figure(
        path,
        rows=2 * len(starts),
        columns=len(maps),
        width_in=2.2 + 3.0 * len(maps),
        height_in=1.2 + 4.4 * len(starts),
        title=f"Exploring with tags (Kleiner 2006, figure 3 (c)), {int(finite(rows[0], 'runs'))} runs",
        sharey="row",
    ) as axes:
        for column, name in enumerate(maps):
            for index, start in enumerate(starts):
                here = [row for row in rows if row["map"] == name and row["start"] == start]
                _scores(axes[2 * index][column], [row for row in here if row["in_order"] == "sequence"])
                _times(axes[2 * index + 1][column], [row for row in here if row["in_order"] == "at once"])
                axes[2 * index][column].set_title(f"{name}, {start} start")
        for index in range(len(starts)):
            axes[2 * index][0].set_ylabel("in sequence: score, m² per m")
            axes[2 * index + 1][0].set_ylabel("at once: time, s")
        axes[0][-1].legend(fontsize=7)
        axes[1][0].legend(fontsize=7)


def _label(row: Row) -> str:
    if row["method"] != "tags":
        return str(row["method"])
    error_m = finite(row, "tag_error_m")
    return f"tags, {finite(row, 'reader_m'):g} m" + (f", {error_m:g} m off" if error_m else "")


def _colours(rows: list[Row]) -> list[str]:
    tags = iter(_TAGS * 4)
    return [_COLOURS.get(str(row["method"])) or next(tags) for row in rows]


def _scores(panel: Axes, rows: list[Row]) -> None:
    for at, (row, colour) in enumerate(zip(rows, _colours(rows), strict=True)):
        deviation = finite(row, "score_sd")
        panel.bar(at, finite(row, "score_mean"), 0.8, yerr=deviation, color=colour, label=_label(row))
    panel.set_xticks([])


def _times(panel: Axes, rows: list[Row]) -> None:
    for row, colour in zip(rows, _colours(rows), strict=True):
        times = [finite(row, f"{name}_s") for name, _ in _TIMES]
        panel.plot(range(len(_TIMES)), times, marker="o", color=colour, label=_label(row))
    panel.set_xticks(range(len(_TIMES)), [label for _, label in _TIMES])
