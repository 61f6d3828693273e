"""The Plaza format: a short drive without noise, odd and damaged files, and the real one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from robots.datasets.plaza import load
from robots.datasets.recording import RecordingError
from robots.datasets.replay import replay
from robots.evaluation import absolute_error

REAL = Path(__file__).parents[4] / "shared" / "data" / "plaza1"


def driven() -> np.ndarray:
    t = 100.0 + 0.2 * np.arange(50)
    return np.column_stack([t, np.full(50, 0.1), 0.02 * np.sin(t)])


def heard() -> np.ndarray:
    t = 100.05 + 0.5 * np.arange(15)
    return np.column_stack([t, np.full(15, 2.0), np.resize([0.0, 5.0], 15), np.linspace(9.0, 12.0, 15)])


def write(folder: Path, dr: np.ndarray | None = None, td: np.ndarray | None = None) -> Path:
    np.savetxt(folder / "X_DR.txt", driven() if dr is None else dr)
    np.savetxt(folder / "X_TD.txt", heard() if td is None else td)
    return folder


def test_motions_add_up_and_ranges_come_when_they_were_made(tmp_path):
    recording = load(write(tmp_path))
    observations = list(recording.observations("r1"))
    assert len(observations) == recording.length("r1") == 65
    assert sum(o.odometry.distance_m for o in observations) == pytest.approx(0.1 * 49)
    assert sum(o.odometry.turn_rad for o in observations) == pytest.approx(driven()[1:, 2].sum())
    ranges = [(o.stamp_s, s.tag_id, s.range_m) for o in observations for s in o.tag_sightings]
    told = [(t, f"N{node:.0f}", range_m) for t, _, node, range_m in heard()]
    assert [(t, node) for t, node, _ in ranges] == [(pytest.approx(t), node) for t, node, _ in told]
    assert [r for *_, r in ranges] == pytest.approx([r for *_, r in told])
    assert recording.truth("r1") is None
    assert recording.tag_places() == {}


def test_rows_out_of_order_go_where_they_belong(tmp_path):
    (tmp_path / "mixed").mkdir()
    mixed = load(write(tmp_path / "mixed", td=heard()[[3, 4, 5, 0, 1, 2, *range(6, 15)]]))
    plain = load(write(tmp_path))
    assert list(mixed.observations("r1")) == list(plain.observations("r1")) or [
        o.tag_sightings for o in mixed.observations("r1")
    ] == [o.tag_sightings for o in plain.observations("r1")]


def test_the_truth_is_read_where_it_is(tmp_path):
    path = np.column_stack([driven()[:, 0], np.zeros((50, 3))])
    path[3, 1] = np.nan
    savemat(tmp_path / "X_.mat", {"GT": path, "TL": np.array([[0.0, 1.0, 2.0], [5.0, 3.0, 4.0]])})
    recording = load(write(tmp_path))
    assert recording.tag_places() == {"N0": (1.0, 2.0), "N5": (3.0, 4.0)}
    truth = recording.truth("r1")
    assert truth is not None
    assert len(truth) == 49


def nan_in(rows: np.ndarray) -> np.ndarray:
    rows[4, 2] = np.nan
    return rows


WRONG = {
    "columns": ({"dr": driven()[:, :2]}, "X_DR.txt has 2 columns"),
    "nan": ({"td": nan_in(heard())}, "X_TD.txt holds a value that is not finite"),
    "negative": ({"td": heard() * [1.0, 1.0, 1.0, -1.0]}, "ranges have to lie between"),
}


@pytest.mark.parametrize(("rows", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_file_is_named(tmp_path, rows, message):
    with pytest.raises(RecordingError, match=message):
        load(write(tmp_path, **rows))


def test_what_is_no_recording_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="is no folder"):
        load(tmp_path / "nothing")
    with pytest.raises(RecordingError, match=r"one file \*_DR.txt; there are 0"):
        load(tmp_path)
    (tmp_path / "X_DR.txt").write_text("once upon a time")
    with pytest.raises(RecordingError, match="is no table of numbers"):
        load(tmp_path)
    write(tmp_path)
    with pytest.raises(RecordingError, match="leave the virtual ones out"):
        load(tmp_path, 2.0)
    (tmp_path / "X_.mat").write_bytes(b"no matlab")
    with pytest.raises(RecordingError, match=r"X_.mat is no intact \.mat"):
        load(tmp_path)


@pytest.mark.data
@pytest.mark.skipif(not REAL.exists(), reason="the Plaza recording is not part of the project")
def test_the_real_recording_online():
    whole = load(REAL)
    half = len(whole.stamps) // 2  # by then odometry alone is 0.8 m off
    recording = replace(
        whole, stamps=whole.stamps[:half], motions=whole.motions[:half], heard=whole.heard[:half]
    )
    truth = recording.truth("r1")
    assert truth is not None
    fewer = {"rslam": {"particles": 300}}  # 1,000 take three times as long
    by_ranges, by_wheels = (
        absolute_error(replay(recording, changes=how).robots[0].online, truth, recording.truth_gap_s).rmse_m
        for how in (fewer, {"slam": "odometry"})
    )
    assert by_ranges < 0.55 < by_wheels
