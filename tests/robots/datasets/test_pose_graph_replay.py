"""Pose graphs one pose at a time: exact without noise, the batch solution in the end, odd graphs survived."""

import numpy as np
import pytest

from robots.datasets import g2o
from robots.datasets.pose_graph_replay import replay_graph
from robots.estimation.graph.solve import solve
from robots.se2 import Pose2

INFORMATION = "100 0 0 100 0 400"
SQUARE = [Pose2(1.0, 0.0, 0.0), Pose2(1.0, 0.0, np.pi / 2)]


def places(count: int) -> list[Pose2]:
    """Round and round a square of two metres."""
    found = [Pose2(0.5, -0.3, 0.2)]
    for k in range(count - 1):
        found.append(found[-1] @ SQUARE[k % 2])
    return found


def edge(i: int, j: int, motion: Pose2) -> str:
    return f"EDGE_SE2 {i} {j} {motion.x!r} {motion.y!r} {motion.theta!r} {INFORMATION}"


def graph(tmp_path, lines: list[str]):
    path = tmp_path / "graph.g2o"
    path.write_text("\n".join(lines) + "\n")
    return g2o.read(path)


def driven(count: int, noise: float = 0.0, names=lambda k: k) -> list[str]:
    """Edges from each place to the next, and to where the robot was a round before."""
    rng, true = np.random.default_rng(1), places(count)
    start = true[0]
    lines = [f"VERTEX_SE2 {names(0)} {start.x!r} {start.y!r} {start.theta!r}"]
    for i, j in [*((k, k + 1) for k in range(count - 1)), *((k, k + 8) for k in range(0, count - 8, 2))]:
        motion = true[i].between(true[j]) @ Pose2.exp(noise * rng.normal(size=3) * [0.1, 0.1, 0.05])
        lines.append(edge(names(i), names(j), motion))
    return lines


def as_array(poses: list[Pose2]) -> np.ndarray:
    return np.array([pose.as_array() for pose in poses])


def errors(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    difference = found - true
    difference[:, 2] = np.angle(np.exp(1j * difference[:, 2]))
    return np.abs(difference)


@pytest.mark.parametrize("slam", ["tag-graph", "odometry"])
def test_without_noise_every_pose_is_exact_when_it_comes(tmp_path, slam):
    result = replay_graph(graph(tmp_path, driven(40)), slam)
    for trajectory in (result.online, result.final):
        assert errors(trajectory.poses, as_array(places(40))).max() < 1e-6
        assert trajectory.stamps_s.tolist() == list(range(40))
    assert result.distance_m == pytest.approx(39.0)
    assert (result.loops, result.solves > 1) == (16, slam == "tag-graph")


def test_in_the_end_it_is_the_batch_solution_and_odometry_alone_is_worse(tmp_path):
    pose_graph = graph(tmp_path, driven(60, noise=1.0))
    result = replay_graph(pose_graph)
    batch = solve(pose_graph.problem()[0], max_iterations=100).poses
    start, other = Pose2.from_array(result.poses[0]), Pose2.from_array(batch[0])
    assert start.as_array() == pytest.approx(places(1)[0].as_array())
    for ours, theirs in zip(result.poses, batch, strict=True):
        expected = other.between(Pose2.from_array(theirs)).as_array()
        assert start.between(Pose2.from_array(ours)).as_array() == pytest.approx(expected, abs=2e-3)
    assert pose_graph.chi2(result.poses) == pytest.approx(pose_graph.chi2(batch), rel=1e-4)
    true = as_array(places(60))
    alone = replay_graph(pose_graph, "odometry")
    assert alone.poses == pytest.approx(alone.reckoned)
    final, online, reckoned = (
        np.mean(errors(poses, true)[:, :2]) for poses in (result.poses, result.online.poses, alone.poses)
    )
    assert final < online < reckoned


def test_ids_are_put_in_order_and_need_not_begin_at_nought_or_fit_64_bits(tmp_path):
    lines = driven(12, names=lambda k: 10**20 + k)
    result = replay_graph(graph(tmp_path, [lines[0], *lines[:0:-1]]))
    assert errors(result.final.poses, as_array(places(12))).max() < 1e-6
    assert np.all(np.diff(result.final.stamps_s) >= 0.0)


def test_a_vertex_that_only_later_ones_know_waits_for_them(tmp_path):
    true = places(6)
    pairs = [(0, 1), (1, 2), (2, 4), (4, 3), (4, 5)]
    begin = f"VERTEX_SE2 0 {true[0].x!r} {true[0].y!r} {true[0].theta!r}"
    result = replay_graph(graph(tmp_path, [begin, *(edge(i, j, true[i].between(true[j])) for i, j in pairs)]))
    assert errors(result.online.poses, as_array(true)).max() < 1e-6


def test_pieces_that_nothing_joins_begin_where_the_file_has_them(tmp_path):
    lines = [
        "VERTEX_SE2 0 0 0 0",
        "VERTEX_SE2 5 10 20 0",
        edge(0, 1, Pose2(1.0, 0.0, 0.0)),
        edge(5, 6, Pose2(0.0, 1.0, 0.0)),
        edge(1, 1, Pose2(3.0, 0.0, 0.0)),
    ]
    result = replay_graph(graph(tmp_path, lines))
    assert result.final.poses == pytest.approx(np.array([[0, 0, 0], [1, 0, 0], [10, 20, 0], [10, 21, 0.0]]))
    assert any("2 pieces" in note for note in result.notes)


def test_a_graph_of_one_vertex_and_no_edge(tmp_path):
    result = replay_graph(graph(tmp_path, ["VERTEX_SE2 7 1 2 0.5"]))
    assert result.final.poses == pytest.approx(np.array([[1.0, 2.0, 0.5]]))
    assert (result.final.stamps_s.tolist(), result.distance_m, result.loops) == ([7.0], 0.0, 0)
