"""The correction of odometry, on a building small enough for a test."""

import numpy as np
import pytest
from PIL import Image

from robots.experiments import kleiner_slam
from robots.experiments.buildings import Building, plans
from robots.experiments.errors import judge
from robots.experiments.experiment import ExperimentError, Options
from robots.se2 import Pose2

TINY = (Building("small", 50.0, "office:50"),)


def measure(runs=2, seed=0, jobs=1, **more):
    return kleiner_slam.measure(Options(runs, seed, jobs, **more), TINY, levels=(2,), minutes=0.8, searches=1)


@pytest.fixture(scope="module")
def progress():
    return []


@pytest.fixture(scope="module")
def rows(progress):
    return measure(progress=lambda done, total: progress.append((done, total)))


def test_a_row_for_each_method_with_units_in_the_names(rows):
    assert [(row["method"], row["heading"]) for row in rows] == [
        ("linear", "IMU"),
        ("gauss-newton", "IMU"),
        ("gauss-newton", "wheels"),
    ]
    for row in rows:
        assert row["runs"] == 2
        for thing in ("trajectory", "tags", "map"):
            for stage in ("odometry", "reckoning", "corrected"):
                assert 0.0 < row[f"{stage}_{thing}_m"] < 30.0
                assert row[f"{stage}_{thing}_sd_m"] >= 0.0
        units = ("_m", "_m2", "_smaller", "_share", "_reckoning")
        unitless = {"map", "tags", "tags_read_again", "explored", "method", "heading", "noise_level", "runs"}
        unitless |= {"paper_figure"}
        assert [name for name in row if not name.endswith(units) and name not in unitless] == []


def test_the_columns_are_in_the_rows(rows):
    for column in kleiner_slam.EXPERIMENT.columns:
        assert column.value in rows[0]
        assert column.deviation is None or column.deviation in rows[0]


def test_the_heading_of_the_inertial_unit_makes_the_difference(rows):
    linear, non_linear, without = rows
    assert linear["corrected_trajectory_m"] < linear["odometry_trajectory_m"]
    assert non_linear["corrected_trajectory_m"] < without["reckoning_trajectory_m"]
    assert without["reckoning_trajectory_m"] == without["odometry_trajectory_m"]


def test_processes_change_nothing_and_seeds_do(rows):
    assert measure(jobs=2) == rows
    assert measure(runs=1, seed=1)[0]["odometry_trajectory_m"] != rows[0]["odometry_trajectory_m"]


def test_progress_comes_to_its_end(rows, progress):
    assert progress[-1] == (4, 4)
    assert progress == sorted(progress)


def test_the_plot_is_drawn(rows, tmp_path):
    path = tmp_path / "plot.png"
    kleiner_slam.EXPERIMENT.plot(rows, path)
    with Image.open(path) as image:
        assert image.width > 600
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20


def test_the_truth_is_judged_as_such(course):
    """And what is merely turned and shifted is wrong from the start, but right once aligned."""
    ticks = np.union1d(np.arange(0, len(course.poses), 10), course.frames)
    order = np.arange(len(course.tags_m))
    moved = Pose2(1.0, -2.0, 0.5)
    back = moved.inverse()
    poses = np.array([(back @ Pose2.from_array(p)).as_array() for p in course.poses[ticks]])
    tags = back.transform(course.tags_m)
    right, wrong = (judge(course, ticks, poses, tags, order, frame) for frame in (moved, Pose2()))
    for errors in (right.aligned, right.from_start, wrong.aligned):
        assert max(errors.trajectory_m, errors.tags_m, errors.map_m) < 1e-9
    assert min(wrong.from_start.trajectory_m, wrong.from_start.tags_m, wrong.from_start.map_m) > 1.0
    larger = judge(course, ticks, poses * (1.1, 1.1, 1.0), tags, order, moved)
    assert larger.aligned.trajectory_m > 0.1
    assert larger.rescaled_m < 1e-9


def test_plans_that_are_not_there_are_named(tmp_path):
    with pytest.raises(ExperimentError, match=r"the plan office-280\.yaml is not in"):
        plans(tmp_path)
    with pytest.raises(ExperimentError, match="give a --data DIR"):
        plans(None)
