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
