"""Computing times: their rows and their plot. How long it takes decides nothing here."""

import numpy as np
import pytest
from PIL import Image

from robots.experiments import kleiner_time
from robots.experiments.buildings import Building
from robots.experiments.experiment import Options

TINY = (Building("small", 40.0, "office:40"), Building("large", 50.0, "office:50"))


@pytest.fixture(scope="module")
def rows():
    return kleiner_time.measure(Options(2), TINY, minutes=0.5, searches=1)


def test_ours_stands_beside_the_papers(rows):
    assert [(row["map"], row["method"]) for row in rows] == [
        ("small", "linear"),
        ("small", "gauss-newton"),
        ("large", "linear"),
        ("large", "gauss-newton"),
    ]
    assert [row["paper_time_s"] for row in rows] == [0.42, 0.42, 13.87, 13.87]
    for row in rows:
        assert row["time_s"] > 0.0
        assert row["time_ms"] == pytest.approx(1e3 * row["time_s"])
        assert row["times_faster"] == pytest.approx(row["paper_time_s"] / row["time_s"])
        assert row["vertices"] > row["tags"] > 0
        assert row["edges"] >= row["vertices"] - 1
        assert row["runs"] == 2
    for column in kleiner_time.EXPERIMENT.columns:
        assert column.value in rows[0]


@pytest.mark.parametrize(("suffix", "start"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<?xml")])
def test_the_plot_is_drawn_in_the_format_its_name_says(rows, tmp_path, suffix, start):
    path = tmp_path / f"time{suffix}"
    kleiner_time.EXPERIMENT.plot(rows, path)
    assert path.stat().st_size > 5_000
    assert path.read_bytes().startswith(start)
    if start == b"\x89PNG":
        with Image.open(path) as image:
            assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20


def test_the_same_rows_give_the_same_file(rows, tmp_path):
    for name in ("a.svg", "b.SVG"):
        kleiner_time.EXPERIMENT.plot(rows, tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.SVG").read_bytes()
