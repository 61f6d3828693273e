"""Pose graphs as files: what is read and written, and what is wrong with them."""

import numpy as np
import pytest

from robots.datasets import g2o
from robots.estimation.graph.solve import GraphError, solve

INFORMATION = "100 0 0 100 0 1000"
SQUARE = f"""# a square
VERTEX_SE2 7 0 0 0
VERTEX_SE2 8 1.1 0.1 1.5
VERTEX_SE2 9 1 1 3.1
EDGE_SE2 7 8 1 0 1.5707963 {INFORMATION}
EDGE_SE2 8 9 1 0 1.5707963 {INFORMATION}
EDGE_SE2 9 7 1.4142135 0 3.1415926 {INFORMATION}
"""


def graph_of(folder, text):
    path = folder / "graph.g2o"
    path.write_text(text)
    return g2o.read(path)


def solved(graph):
    problem, notes = graph.problem()
    return solve(problem, max_iterations=100), notes


def test_a_file_is_read_and_written_back(tmp_path):
    graph = graph_of(tmp_path, SQUARE + "FIX 8\n")
    assert graph.ids == (7, 8, 9)
    assert graph.pairs.tolist() == [[0, 1], [1, 2], [2, 0]]
    np.testing.assert_array_equal(graph.information[0], np.diag([100.0, 100.0, 1000.0]))
    assert graph.notes == ()
    g2o.write(tmp_path / "again.g2o", graph, graph.poses)
    again = g2o.read(tmp_path / "again.g2o")
    for name in ("ids", "held", "notes"):
        assert getattr(again, name) == getattr(graph, name)
    for name in ("poses", "pairs", "measured", "information"):
        assert np.array_equal(getattr(again, name), getattr(graph, name))


def test_the_upper_triangle_of_the_information_is_read_row_by_row(tmp_path):
    graph = graph_of(tmp_path, "EDGE_SE2 0 1 1 2 3 11 .12 .13 22 .23 33\n")
    np.testing.assert_array_equal(
        graph.information[0], [[11, 0.12, 0.13], [0.12, 22, 0.23], [0.13, 0.23, 33]]
    )
    expected = np.array([0.5, 0.0, 0.0])
    assert graph.chi2(np.array([[0, 0, 0], [1.5, 2, 3.0]])) == pytest.approx(
        expected @ graph.information[0] @ expected
    )


def test_the_vertex_that_is_held_stays(tmp_path):
    solution, _ = solved(graph_of(tmp_path, SQUARE + "FIX 8\n"))
    np.testing.assert_allclose(solution.poses[1], [1.1, 0.1, 1.5], atol=1e-5)
    assert solution.chi2 < solution.chi2_initial


def test_vertices_that_only_edges_name_are_placed_along_them(tmp_path):
    chain = f"EDGE_SE2 5 3 1 0 1.5707963 {INFORMATION}\nEDGE_SE2 4 3 0 2 0 {INFORMATION}\n"
    graph = graph_of(tmp_path, chain)
    np.testing.assert_allclose(graph.poses, [[0, 0, 0], [1, 0, np.pi / 2], [3, 0, np.pi / 2]], atol=1e-6)
    assert graph.notes == ("vertices that only edges name were placed along them: 5, 3, 4",)
    assert graph.chi2(graph.poses) == pytest.approx(0.0, abs=1e-12)


def test_pieces_are_each_held_at_their_own_first_vertex(tmp_path):
    other = (
        f"VERTEX_SE2 20 9 9 1\nVERTEX_SE2 21 5 5 0\nEDGE_SE2 20 21 1 0 0 {INFORMATION}\nVERTEX_SE2 30 4 4 1\n"
    )
    graph = graph_of(tmp_path, SQUARE + other)
    solution, notes = solved(graph)
    assert notes == ("the graph is in 3 pieces; held where they are: 7, 20, 30",)
    np.testing.assert_allclose(solution.poses[[0, 3, 5]], [[0, 0, 0], [9, 9, 1], [4, 4, 1]], atol=1e-6)
    np.testing.assert_allclose(solution.poses[4], [9 + np.cos(1), 9 + np.sin(1), 1], atol=1e-6)
    alone, _ = solved(graph_of(tmp_path, SQUARE))
    np.testing.assert_allclose(solution.poses[:3], alone.poses, atol=1e-4)


def test_edges_of_a_vertex_to_itself_and_ids_given_twice_are_noted_and_survived(tmp_path):
    odd = f"VERTEX_SE2 8 1 0 1.57\nEDGE_SE2 9 9 1 0 0 {INFORMATION}\nEDGE_SE3:QUAT 1 2\n"
    graph = graph_of(tmp_path, SQUARE + odd)
    assert graph.notes == (
        "lines of a kind not known were left out: EDGE_SE3:QUAT (1 times)",
        "vertices given more than once, the last place stands: 8",
        "edges of a vertex to itself change nothing: 9",
    )
    solution, _ = solved(graph)
    alone, _ = solved(graph_of(tmp_path, SQUARE))
    assert solution.chi2 == pytest.approx(alone.chi2 + 100.0)  # the metre that it is wrong about itself
    np.testing.assert_allclose(solution.poses, alone.poses, atol=1e-4)


def test_a_graph_without_edges_stays_where_it_is(tmp_path):
    solution, _ = solved(graph_of(tmp_path, "VERTEX_SE2 1 2 3 0.5\nVERTEX_SE2 2 4 5 0.6\n"))
    np.testing.assert_allclose(solution.poses, [[2, 3, 0.5], [4, 5, 0.6]], atol=1e-12)
    assert solution.chi2 == 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no VERTEX_SE2 and no EDGE_SE2 line"),
        ("VERTEX_SE2 1 0 0\n", "line 1: VERTEX_SE2 has 4 numbers, not 3"),
        ("VERTEX_SE2 x 0 0 0\n", "line 1: could not convert"),
        ("VERTEX_SE2 1.5 0 0 0\n", "line 1: invalid literal"),
        ("VERTEX_SE2 1 0 nan 0\n", "line 1: a number is not finite"),
        (f"\nEDGE_SE2 0 1 inf 0 0 {INFORMATION}\n", "line 2: a number is not finite"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n", "line 1: EDGE_SE2 has 11 numbers, not 10"),
        ("EDGE_SE2 0 1 1 0 0 1 0 0 -1 0 1\n", "line 1: the information matrix has a negative eigenvalue"),
        ("FIX\n", "line 1: FIX has 1 numbers, not 0"),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path, text, message):
    with pytest.raises(GraphError, match=message):
        graph_of(tmp_path, text)


def test_files_that_are_not_there_are_named(tmp_path):
    with pytest.raises(GraphError, match="cannot read the graph"):
        g2o.read(tmp_path / "absent.g2o")
    graph = graph_of(tmp_path, SQUARE)
    with pytest.raises(GraphError, match="cannot write"):
        g2o.write(tmp_path / "no folder" / "out.g2o", graph, graph.poses)
