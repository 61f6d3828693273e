"""`waymark solve`, run as a user would."""

import json

import numpy as np
import pytest

from robots.datasets import g2o
from server.cli.main import run

GRAPH = """VERTEX_SE2 1 0 0 0
VERTEX_SE2 2 0.8 0.1 0.1
EDGE_SE2 1 2 1 0 0 100 0 0 100 0 100
EDGE_SE2 2 3 1 0 0 100 0 0 100 0 100
EDGE_SE2 1 3 2.3 0 0 100 0 0 100 0 100
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "graph.g2o"
    path.write_text(GRAPH)
    return path


@pytest.mark.parametrize("method", ["gauss-newton", "linear"])
def test_a_graph_is_solved_and_written(path, tmp_path, capsys, method):
    out = tmp_path / "out.g2o"
    assert run(["solve", str(path), "--method", method, "--out", str(out), "--json"]) == 0
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    assert list(result) == ["vertices", "edges", "iterations", "chi2_initial", "chi2", "solve_ms"]
    assert (result["vertices"], result["edges"]) == (3, 3)
    assert result["chi2"] == pytest.approx(100 * 3 * 0.1**2)  # 0.3 m shared by three edges
    assert result["chi2_initial"] > result["chi2"]
    assert result["solve_ms"] > 0.0
    assert "Note: vertices that only edges name were placed along them: 3." in printed.err
    np.testing.assert_allclose(g2o.read(out).poses, [[0, 0, 0], [1.1, 0, 0], [2.2, 0, 0]], atol=1e-4)


def test_people_get_a_table(path, capsys):
    assert run(["solve", str(path)]) == 0
    assert "chi2_initial" in capsys.readouterr().out


def test_what_is_wrong_is_one_sentence(path, tmp_path, capsys):
    assert run(["solve", str(tmp_path / "absent.g2o")]) == 1
    assert "cannot read the graph" in capsys.readouterr().err
    assert run(["solve", str(path), "--method", "guess"]) == 1
    assert "--method has to be gauss-newton or linear, not 'guess'." in capsys.readouterr().err
    path.write_text("VERTEX_SE2 1 0 0 nan\n")
    assert run(["solve", str(path)]) == 1
    assert capsys.readouterr().err == "graph.g2o, line 1: a number is not finite.\n"


def test_a_wrong_loop_is_left_out_when_loops_may_be_wrong(path, tmp_path, capsys):
    path.write_text(GRAPH + "EDGE_SE2 1 3 -5 4 2 100 0 0 100 0 100\nEDGE_SE2 1 3 2.1 0 0 100 0 0 100 0 100\n")
    out = tmp_path / "out.g2o"
    assert run(["solve", str(path), "--robust", "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["edges_left_out"] == 1
    assert g2o.read(out).poses[2, 0] == pytest.approx(2.16, abs=0.01)  # 2.0 by two edges, 2.3 and 2.1
    assert run(["solve", str(path), "--out", str(out)]) == 0
    assert abs(g2o.read(out).poses[2, 1]) > 0.3  # what it does otherwise


@pytest.mark.parametrize("name", ["solve", "incremental"])
def test_the_benchmarks_of_graphs_reach_the_optimum(path, capsys, name):
    assert run(["bench", name, "--graph", str(path), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)[f"{name} graph"]
    assert result["chi2"] == pytest.approx(100 * 3 * 0.1**2, rel=1e-3)


def test_a_graph_that_is_to_grow_has_to_be_named(capsys):
    assert run(["bench", "incremental"]) == 1
    assert "needs a pose graph" in capsys.readouterr().err


def test_the_small_graph_is_measured_without_a_file(capsys):
    assert run(["bench", "solve", "--json"]) == 0
    small = json.loads(capsys.readouterr().out)["solve small"]
    assert (small["vertices"], small["edges"]) == (50, 200)
    assert small["chi2"] == pytest.approx(3 * (200 - 49), rel=0.25)  # one a number beyond what is free
    assert small["covariances_ms"] > 0.0
