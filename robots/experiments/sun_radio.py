"""Sun 2009 figure 2: signal strength and the distance told from it, against the true distance.

At each distance many places: each has a shadowing of its own and is heard ten times, outliers among them; one
mean is made of the ten (RANSAC) and turned into a distance.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robots.estimation.radio.model import NODE, RadioModel
from robots.estimation.radio.signal_mean import robust_mean
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, Options, Row, finite
from robots.experiments.radio_course import SPIKE_DB, SPIKE_SHARE

DISTANCES_M = (1.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0, 22.5, 25.0, 27.5, 30.0, 32.5, 35.0)


def measure(options: Options) -> list[Row]:
    """Return a row for each distance; each run is one place at every distance."""
    model, rows = RadioModel(NODE), []
    for number, distance_m in enumerate(DISTANCES_M):
        random = np.random.default_rng([options.seed, number])
        places = [_place(model, distance_m, random) for _ in range(options.runs)]
        found = np.array([place for place in places if place is not None])
        rows.append(_row(model, distance_m, options.runs, found))
        options.progress(number + 1, len(DISTANCES_M))
    return rows


def _place(
    model: RadioModel, distance_m: float, random: np.random.Generator
) -> tuple[float, float, float] | None:
    """Return the plain mean of ten readings at a place, the mean without outliers, and the distance told."""
    mean_dbm = model.signal_dbm(distance_m) + model.shadowing_sd_db(distance_m) * random.standard_normal()
    readings = mean_dbm + NODE.fading_sd_db * random.standard_normal(NODE.readings)
    spiked = random.random(NODE.readings) < SPIKE_SHARE
    readings += spiked * random.uniform(*SPIKE_DB, NODE.readings) * random.choice((-1, 1), NODE.readings)
    mean = robust_mean(readings, NODE.fading_sd_db)
    if mean is None:
        return None
    told = model.range_of(mean.rssi_dbm, mean.readings)
    return float(readings.mean()), mean.rssi_dbm, told.median_m


def _row(model: RadioModel, distance_m: float, runs: int, found: np.ndarray) -> Row:
    plain, robust, told = found.T
    return {
        "distance_m": distance_m,
        "runs": runs,
        "model_dbm": model.signal_dbm(distance_m),
        "rssi_dbm": float(robust.mean()),
        "rssi_sd_db": float(robust.std()),
        "plain_rssi_sd_db": float(plain.std()),
        "shadowing_sd_db": model.shadowing_sd_db(distance_m),
        "estimate_m": float(told.mean()),
        "estimate_sd_m": float(told.std()),
    }


def draw(rows: list[Row], path: Path) -> None:
    """Draw both panels of the figure."""
    distances = [finite(row, "distance_m") for row in rows]
    with plotting.figure(
        path, rows=1, columns=2, width_in=9.0, height_in=3.8, title="Radio of the nodes (Sun 2009, figure 2)"
    ) as axes:
        signal, told = axes[0]
        for panel, value, spread in (
            (signal, "rssi_dbm", "rssi_sd_db"),
            (told, "estimate_m", "estimate_sd_m"),
        ):
            panel.errorbar(
                distances, [finite(row, value) for row in rows], [finite(row, spread) for row in rows],
                color=plotting.GREEN, ecolor=plotting.VERMILION, marker="o", capsize=2.5, linestyle="none",
                label="mean of ten readings",
            )  # fmt: skip
            panel.set_xlabel("distance, m")
        signal.plot(
            distances, [finite(row, "model_dbm") for row in rows], color=plotting.GREY, label="eq. (1)"
        )
        told.plot(distances, distances, color=plotting.GREY, label="the truth")
        signal.set_ylabel("signal, dBm")
        told.set_ylabel("estimated distance, m")
        signal.legend()
        told.legend()


EXPERIMENT = Experiment(
    name="sun-radio",
    summary="Signal strength of nodes against distance, and the distance estimated from it.",
    paper="Sun 2009, figure 2",
    default_runs=200,
    run=measure,
    plot=draw,
    columns=(
        Column("distance m", "distance_m", digits=1),
        Column("model dBm", "model_dbm", digits=1),
        Column("mean dBm", "rssi_dbm", "rssi_sd_db", digits=1),
        Column("with outliers, sd dB", "plain_rssi_sd_db", digits=1),
        Column("shadowing sd dB", "shadowing_sd_db", digits=1),
        Column("estimated m", "estimate_m", "estimate_sd_m", digits=1),
    ),
    notes=(
        "Mean ± deviation over places; each is heard ten times, 5 % of the readings are off by 10 to 30 dB.",
        "The distance is eq. (1) inverted; its error is log-normal, so far off it is too long on average.",
        "The paper shows figure 2 and prints p(d0) = -12 dB and n = 2; its table of deviations is a plot.",
    ),
)
