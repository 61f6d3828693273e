"""The plot of ``kleiner-cellar``: the error of the relations over the spacing of the tags."""

from __future__ import annotations

from pathlib import Path

from robots.experiments import plotting
from robots.experiments.experiment import Row, finite

_CURVES = (
    (False, "online", "no laser loops, online", plotting.ORANGE, "v", "--"),
    (False, "final", "no laser loops, final", plotting.ORANGE, "v", "-"),
    (True, "online", "laser loops, online", plotting.BLUE, "o", "--"),
    (True, "final", "laser loops, final", plotting.BLUE, "o", "-"),
)
_MARKS = (
    ("raw_odometry_relations_m", "raw odometry", plotting.VERMILION),
    ("reference_relations_m", "reference path", plotting.GREY),
    ("rbpf_relations_m", "RBPF", plotting.BLACK),
    ("graph_mapping_relations_m", "graph mapping", plotting.BLACK),
)


def draw(rows: list[Row], path: Path) -> None:
    """Draw online and final errors, with and without laser loops, and what others reached as lines."""
    spacings = list(dict.fromkeys(str(row["tag_spacing"]) for row in rows))
    title = "Intel Research Lab with virtual tags (for Kleiner 2006, figure 6)"
    with plotting.figure(path, rows=1, columns=1, width_in=8.6, height_in=4.6, title=title) as axes:
        panel = axes[0][0]
        for name, label, colour in _MARKS:
            value = finite(rows[0], name)
            panel.axhline(value, color=colour, linestyle=":", linewidth=1.0)
            panel.annotate(
                f"{label}: {value:.3f} m", (1.0, value), xycoords=("axes fraction", "data"), xytext=(4, 0),
                textcoords="offset points", va="center", fontsize=7.5, color=colour, annotation_clip=False,
            )  # fmt: skip
        for laser, kind, label, colour, marker, style in _CURVES:
            chosen = [row for row in rows if row["laser_loops"] is laser]
            if chosen:
                panel.errorbar(
                    [spacings.index(str(row["tag_spacing"])) for row in chosen],
                    [finite(row, f"{kind}_relations_m") for row in chosen],
                    [finite(row, f"{kind}_relations_sd_m") for row in chosen],
                    color=colour, marker=marker, linestyle=style, capsize=2.5, label=label,
                    fillstyle="full" if kind == "final" else "none",
                )  # fmt: skip
        panel.set_yscale("log")
        panel.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        panel.set_xticks(range(len(spacings)), spacings)
        panel.set_xlim(-0.4, len(spacings) - 0.4)
        panel.set_xlabel("a tag every")
        panel.set_ylabel("mean translational error of the relations, m")
        panel.legend(loc="center", bbox_to_anchor=(0.4, 0.72), ncols=2)
