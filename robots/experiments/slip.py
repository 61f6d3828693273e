"""Slip detection on worlds and wheel gains never seen, and what it does to the trajectory.

Kleiner 2006 section IV and figure 2 show a decision tree that "reliably detects this slippage"; no figure of
its accuracy is printed. Each run drives worlds of its own, trains both trees on some and tests them on
others: no floor, no robot and no stretch of driving is on both sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from robots.config import BodyConfig
from robots.estimation.odometry import motion_mean
from robots.estimation.slip.detector import SlipDetector
from robots.estimation.slip.tree import SlipTree, SlipTrees
from robots.experiments.experiment import Column, Experiment, ExperimentError, Options, Row
from robots.experiments.parallel import in_parallel
from robots.experiments.plotting import BLUE, GREY, ORANGE, YELLOW, figure
from robots.se2 import Array, Pose2, wrap
from robots.sim.physics.drive import Drive, PhysicsError, drive_world
from robots.sim.physics.fit import Lessons, Verdict, boosted_verdict, fit_trees, joined, judge, lessons
from robots.sim.physics.train import SECONDS, kinematic_lessons, world_seeds

TRAIN_WORLDS, TEST_WORLDS = 60, 20
DETECTORS = ("none", "basic", "boosted", "extended")


@dataclass(frozen=True, slots=True)
class Measured:
    """How one detector did on the test worlds of one run.

    ``verdict`` takes the likelier class, ``alarms`` what the agent acts on; ``drift_percent`` is the error of
    dead reckoning at the end in percent of the way, mean over worlds; None where nothing drives by it.
    """

    detector: str
    verdict: Verdict | None
    alarms: Verdict | None
    drift_percent: float | None
    slip_share: float


def measure(trees: SlipTrees, drives: Sequence[Drive]) -> list[Measured]:
    """Return how no detector, the basic and the extended tree do on drives."""
    learnt = lessons(drives)
    share = float(learnt.slips.mean())
    found = [Measured("none", None, None, _mean_drift(drives, None), share)]
    for tree, features, kind in (
        (trees.basic, learnt.basic, "basic"),
        (trees.extended, learnt.extended, "extended"),
    ):
        shares = _shares(tree, features)
        verdict, alarms = judge(shares > 0.5, learnt.slips), judge(shares > tree.alarm_above, learnt.slips)
        detector = partial(SlipDetector, kind, trees)  # type: ignore[arg-type]
        found.append(Measured(kind, verdict, alarms, _mean_drift(drives, detector), share))
    return found


def drift_percent(drive: Drive, detector: SlipDetector | None) -> float:
    """Return the error of dead reckoning with the gyro's heading at the end, in percent of the way driven."""
    believed, yaw = Pose2.from_array(drive.poses[0]), float(drive.poses[0, 2])
    for sample in drive.samples():
        turn, yaw = wrap(sample.imu.yaw_rad - yaw), sample.imu.yaw_rad
        motion = motion_mean(sample.odometry, turn, BodyConfig())
        if detector is not None and detector.observe(
            sample.stamp_s, sample.odometry, sample.imu, sample.command
        ):
            motion = Pose2(0.0, 0.0, motion.theta)
        believed = believed @ motion
    way = float(np.hypot(*np.diff(drive.poses[:, :2], axis=0).T).sum())
    return 100.0 * believed.distance(Pose2.from_array(drive.poses[-1])) / way


def run(options: Options) -> list[Row]:
    """Train and test anew in every run; one row a detector, mean and deviation over runs.

    Raises:
        ExperimentError: MuJoCo or scikit-learn are not installed.
    """
    try:
        import mujoco  # noqa: F401
        import sklearn  # noqa: F401
    except ImportError as error:
        raise ExperimentError(
            f"slip needs {error.name}; install it by pip install 'waymark[physics]'"
        ) from None
    tasks = [(options.seed, number, TRAIN_WORLDS, TEST_WORLDS, SECONDS) for number in range(options.runs)]
    try:
        results = in_parallel(measure_run, tasks, options.jobs, options.progress)
    except PhysicsError as error:
        raise ExperimentError(str(error)) from error
    return rows_of(results)


def measure_run(task: tuple[int, int, int, int, float]) -> list[Measured]:
    """Return one run: (seed, its number, worlds to train on, worlds to test on, seconds in each)."""
    seed, number, train_worlds, test_worlds, seconds = task
    own = int(np.random.default_rng([seed, number, 3]).integers(2**62))
    worlds = world_seeds(own, train_worlds + test_worlds)
    taught = worlds[:train_worlds]
    learnt: Lessons = joined([lessons([drive_world(world, seconds)]) for world in taught])
    trees = fit_trees(learnt, kinematic_lessons(taught, seconds))
    others = [drive_world(world, seconds) for world in worlds[train_worlds:]]
    asked = lessons(others)
    bound = Measured("boosted", boosted_verdict(learnt, asked), None, None, float(asked.slips.mean()))
    none, basic, extended = measure(trees, others)
    return [none, basic, bound, extended]


def rows_of(results: Sequence[Sequence[Measured]]) -> list[Row]:
    """Return one row a detector from the runs' results."""
    rows: list[Row] = []
    for k, detector in enumerate(DETECTORS):
        found = [result[k] for result in results]
        row: Row = {"detector": detector, "runs": len(found)}
        verdicts = [item.verdict for item in found if item.verdict is not None]
        alarms = [item.alarms for item in found if item.alarms is not None]
        row |= _statistics("balanced_accuracy", [verdict.balanced_accuracy for verdict in verdicts])
        row |= _statistics("miss_rate", [verdict.miss_rate for verdict in verdicts])
        row |= _statistics("false_alarm_rate", [verdict.false_alarm_rate for verdict in verdicts])
        row |= _statistics("acted_miss_rate", [verdict.miss_rate for verdict in alarms])
        row |= _statistics("acted_false_alarm_rate", [verdict.false_alarm_rate for verdict in alarms])
        row |= _statistics(
            "drift_percent", [item.drift_percent for item in found if item.drift_percent is not None]
        )
        row |= _statistics("slip_share", [item.slip_share for item in found])
        rows.append(row)
    return rows


def plot(rows: list[Row], path: Path) -> None:
    """Draw accuracy and drift of the detectors. Raises ExperimentError when the file cannot be written."""
    names = [str(row["detector"]) for row in rows]
    colours = [GREY, ORANGE, YELLOW, BLUE]
    with figure(path, 1, 2, 7.0, 3.2, "Slip on unseen worlds and wheel gains") as axes:
        for panel, value, title in (
            (axes[0][0], "balanced_accuracy", "balanced accuracy"),
            (axes[0][1], "drift_percent", "drift, % of the way"),
        ):
            heights = [_drawn(row[value]) for row in rows]
            panel.bar(names, heights, yerr=[_drawn(row[f"{value}_sd"]) for row in rows], color=colours)
            panel.set_title(title)
        axes[0][0].set_ylim(0.5, 1.0)


def _drawn(value: object) -> float:
    return float(value) if isinstance(value, int | float) else float("nan")


def _shares(tree: SlipTree, features: Array) -> Array:
    return np.array([tree.share(values) for values in features.tolist()])


def _mean_drift(drives: Sequence[Drive], detector: partial[SlipDetector] | None) -> float:
    return float(np.mean([drift_percent(drive, detector() if detector else None) for drive in drives]))


def _statistics(name: str, values: Sequence[float]) -> Row:
    """Return mean and deviation over runs; None where the detector has no such value."""
    if not values:
        return {name: None, f"{name}_sd": None}
    return {name: float(np.mean(values)), f"{name}_sd": float(np.std(values))}


EXPERIMENT = Experiment(
    name="slip",
    summary="Slip trees on worlds and wheel gains never seen, and the drift with and without them",
    paper="Kleiner 2006 section IV, figure 2 (no figure of the accuracy is printed)",
    default_runs=5,
    run=run,
    plot=plot,
    columns=(
        Column("detector", "detector"),
        Column("balanced accuracy", "balanced_accuracy", "balanced_accuracy_sd", 3),
        Column("missed", "miss_rate", "miss_rate_sd", 3),
        Column("false alarms", "false_alarm_rate", "false_alarm_rate_sd", 3),
        Column("missed, acted", "acted_miss_rate", "acted_miss_rate_sd", 3),
        Column("false alarms, acted", "acted_false_alarm_rate", "acted_false_alarm_rate_sd", 3),
        Column("drift %", "drift_percent", "drift_percent_sd", 2),
    ),
    notes=(
        f"Each run trains on {TRAIN_WORLDS} worlds and tests on {TEST_WORLDS} others, {SECONDS:g} s in each.",
        'Boosted: 150 boosted trees on the inputs of "basic", which shows what these four differences hold.',
        'Balanced accuracy takes the likelier class; the agent acts on surer answers only ("acted").',
        "Drift: dead reckoning with the gyro's heading, error at the end in percent of the way.",
    ),
)
