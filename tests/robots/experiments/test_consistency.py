"""Claims against truth: the arithmetic on made-up claims, and one short mission for real."""

from dataclasses import replace

import numpy as np
import pytest

from robots.experiments import consistency
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig


def claims(alarms, tags):
    return consistency.Claims(np.array([1.0, 40.0]), np.full(tags, 2.0), np.array([1.0, 3.0]), alarms, 2)


def test_rows_count_what_the_missions_claimed(tmp_path):
    rows = [consistency.row_of("all", 2, [claims(0, 60), claims(1, 40)])]
    (row,) = rows
    assert (row["missions"], row["displacements"], row["displacements_beyond_30"]) == (2, 4, 2)
    assert (row["tags"], row["false_alarms"], row["missions_with_false_alarms"]) == (100, 1, 1)
    assert row["false_alarm_percent"] == pytest.approx(1.0)
    assert row["joint_nees_per_dof"] == pytest.approx(2.0)
    assert all(column.value in row for column in consistency.EXPERIMENT.columns)
    pytest.importorskip("matplotlib")
    consistency.plot(rows, tmp_path / "c.png")
    assert (tmp_path / "c.png").stat().st_size > 5_000


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [(0, 300, 0.0, 0.01222), (1, 100, 0.000253, 0.05446), (5, 5, 0.4782, 1.0)],
)
def test_the_interval_of_a_rate_is_that_of_clopper_and_pearson(count, total, low, high):
    assert consistency.interval(count, total) == pytest.approx((low, high), rel=1e-3)


def test_a_mission_is_held_against_its_truth():
    robot = run(ScenarioConfig(map="office:60", robots=1, minutes=0.5, seed=2, victims=0)).robots[0]
    nees = consistency.displacement_nees(robot)
    graph = robot.report.graph
    assert graph is not None
    assert len(nees) == len(graph.edge_pairs)
    assert np.median(nees) < 20.0
    off = replace(graph, edge_poses=graph.edge_poses + np.array([0.5, 0.0, 0.0]))
    worse = consistency.displacement_nees(replace(robot, report=replace(robot.report, graph=off)))
    assert (worse > nees).all()
    found = consistency.measure(("office:60", 1, 0.5, 2))
    assert len(found.tags) == len(graph.tag_ids)
    assert np.isfinite(found.displacements).all()
