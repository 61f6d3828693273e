"""The plot of Ziparo 2007 table 2: ours beside the paper's, by building."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robots.experiments.experiment import Row, finite
from robots.experiments.plotting import BLUE, GREY, ORANGE, figure

_TITLES = {"cross_track": "Cross-track", "along_track": "Along-track", "cartesian": "Cartesian"}


def draw(rows: list[Row], path: Path) -> None:
    """Draw a panel for each error: mean with deviation over the way, and the maximum.

    Raises:
        ExperimentError: the file cannot be written.
    """
    at = np.arange(len(rows), dtype=np.float64)
    with figure(path, 1, 3, 9.5, 3.2, "EKF-SLAM over UHF tags (Ziparo 2007, table 2)", sharey=True) as axes:
        for panel, (stem, title) in zip(axes[0], _TITLES.items(), strict=True):
            for side, prefix, colour, label in ((-0.2, "", BLUE, "ours"), (0.2, "paper_", ORANGE, "paper")):
                mean = [finite(row, f"{prefix}{stem}_m") for row in rows]
                spread = [finite(row, f"{prefix}{stem}_sd_m") for row in rows]
                most = [finite(row, f"{prefix}{stem}_max_m") for row in rows]
                panel.bar(at + side, mean, 0.36, yerr=spread, color=colour, ecolor=GREY, label=label)
                panel.plot(at + side, most, "v", color=colour)
            panel.set_xticks(at, [str(row["building"]).replace(" ", "\n") for row in rows])
            panel.set_title(title)
        axes[0][0].set_ylabel("error in m: mean, deviation, ▾ maximum")
        axes[0][0].legend()
