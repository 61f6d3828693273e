"""Drawing the safe areas of ``amigoni``: a panel for each map and team, the paper's means beside ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robots.experiments import plotting
from robots.experiments.experiment import Row, finite

_COLOURS = (plotting.BLUE, plotting.ORANGE)


def draw(rows: list[Row], path: Path) -> None:
    """Draw means and deviations of the safe area by method."""
    means = [row for row in rows if row["what"] == "safe area"]
    maps = list(dict.fromkeys(str(row["map"]) for row in means))
    teams = sorted({int(finite(row, "robots")) for row in means})
    costs = sorted({finite(row, "plan_cost_s") for row in means})
    title = "Safe area after 15 minutes (Amigoni 2013, table 1)"
    with plotting.figure(
        path,
        rows=len(maps),
        columns=len(teams),
        width_in=4.2 * len(teams),
        height_in=3.6 * len(maps),
        title=title,
    ) as axes:
        for line, map_name in zip(axes, maps, strict=True):
            for panel, team in zip(line, teams, strict=True):
                here = [r for r in means if r["map"] == map_name and finite(r, "robots") == team]
                methods = list(dict.fromkeys(str(row["method"]) for row in here))
                places = np.arange(len(methods), dtype=np.float64)
                for k, cost in enumerate(costs):
                    bars = [row for row in here if finite(row, "plan_cost_s") == cost]
                    at = places + (k - (len(costs) - 1) / 2.0) * 0.38
                    panel.bar(
                        at,
                        [finite(row, "safe_m2") for row in bars],
                        0.36,
                        yerr=[finite(row, "safe_sd_m2") for row in bars],
                        color=_COLOURS[k % len(_COLOURS)],
                        error_kw={"lw": 1.0},
                        label=f"{cost:.0f} s a way",
                    )
                printed = [finite(row, "paper_m2") for row in here if finite(row, "plan_cost_s") == costs[0]]
                panel.plot(places, printed, "D", color=plotting.BLACK, label="paper")
                panel.set_xticks(places, methods, rotation=40, ha="right")
                panel.set_title(f"{map_name}, {team} robot{'s' * (team > 1)}")
                panel.set_ylabel("safe area, m²")
        axes[0][-1].legend(loc="lower right")
