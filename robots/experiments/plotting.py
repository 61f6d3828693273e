"""How plots look: one style for all, drawn by matplotlib, which is loaded when the first is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robots.experiments.experiment import ExperimentError

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

SUFFIXES = (".png", ".pdf", ".svg")

# Okabe and Ito 2008: told apart with every kind of colour vision, and by lightness when printed grey
BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE = (
    "#000000", "#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7",
)  # fmt: skip
GREY = "#6b6b6b"

_STYLE: Any = {
    "figure.dpi": 150,
    "font.size": 9.0,
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same on every machine
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e2e2e2",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.6,
    "lines.markersize": 5.0,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.hashsalt": "waymark",  # the same rows give the same file
}


def check_plot(path: Path) -> None:
    """Say in one sentence why a plot cannot be drawn to a path, before the work it would show.

    Raises:
        ExperimentError: the suffix names no format, the folder does not exist, or matplotlib is missing.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ExperimentError(f"--plot {path}: the name has to end in {', '.join(SUFFIXES[:-1])} or .svg")
    if not path.absolute().parent.is_dir():
        raise ExperimentError(f"--plot {path}: there is no folder {path.parent}")
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise ExperimentError("--plot needs matplotlib; install it with pip install matplotlib") from error


@contextmanager
def figure(
    path: Path, rows: int, columns: int, width_in: float, height_in: float, title: str, **grid: Any
) -> Iterator[list[list[Axes]]]:
    """Yield the axes of a figure, [row][column], and write it to the path in the end.

    Raises:
        ExperimentError: the file cannot be written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(_STYLE):
        sheet = Figure(figsize=(width_in, height_in), layout="constrained")
        FigureCanvasAgg(sheet)  # no window, no global state
        axes = sheet.subplots(rows, columns, squeeze=False, **grid)
        sheet.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
        yield axes.tolist()
        suffix = path.suffix.lower()
        metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(suffix)
        try:
            sheet.savefig(path, format=suffix[1:], metadata=metadata)
        except OSError as error:
            raise ExperimentError(f"--plot {path}: cannot be written ({error.strerror})") from error
