"""The Intel recording with virtual tags: what can be said without replaying it, and its rows and plot."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from robots.experiments import kleiner_cellar
from robots.experiments.experiment import ExperimentError, Options
from robots.experiments.kleiner_cellar import placed_from

DATA = Path(__file__).parents[4] / "shared" / "data"


def test_what_is_missing_is_named(tmp_path):
    with pytest.raises(ExperimentError, match=r"the recording intel_raw_2726\.npz is not in"):
        kleiner_cellar.measure(Options(1, data=tmp_path))
    (tmp_path / "intel_raw_2726.npz").write_bytes(b"nothing")
    with pytest.raises(ExperimentError, match=r"the recording intel\.relations is not in"):
        kleiner_cellar.measure(Options(1, data=tmp_path))
    (tmp_path / "intel.relations").write_text("")
    with pytest.raises(ExperimentError, match="not an intact"):
        kleiner_cellar.measure(Options(1, data=tmp_path))


@pytest.mark.data
@pytest.mark.skipif(
    not (DATA / kleiner_cellar.RECORDING).exists(), reason="the Intel recording is not part of the project"
)
def test_the_first_minutes_of_the_recording(tmp_path):
    with np.load(DATA / kleiner_cellar.RECORDING) as whole:
        np.savez(tmp_path / kleiner_cellar.RECORDING, **{name: whole[name][:160] for name in whole.files})
    (tmp_path / kleiner_cellar.RELATIONS).write_text((DATA / kleiner_cellar.RELATIONS).read_text())
    rows = kleiner_cellar.measure(Options(2, data=tmp_path), (2.0, None))
    assert [(row["tag_spacing"], row["laser_loops"], row["runs"]) for row in rows] == [
        ("2 m", False, 2),
        ("no tags", False, 1),
        ("2 m", True, 2),
    ]
    tags, none, _ = rows
    assert tags["tags"] > 1.0
    assert tags["sightings"] >= tags["tags"]
    assert none["tags"] == none["sightings"] == 0.0
    for row in rows:
        assert 0.0 < row["final_relations_m"] < row["raw_odometry_relations_m"]


def test_tags_are_sighted_where_they_lie_whatever_frame_the_first_is_at():
    angle = np.linspace(0.0, 4.0 * np.pi, 400)
    path = 5.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    for first in (0, 37, 399):
        tags = placed_from(path, 2.0, first)
        np.testing.assert_array_equal(tags.places_m[0], path[first])
        gaps = np.linalg.norm(tags.places_m[:, None] - tags.places_m[None], axis=2)
        assert gaps[~np.eye(len(gaps), dtype=bool)].min() >= 2.0
        for frame, numbers in tags.sighted.items():
            assert np.linalg.norm(tags.places_m[list(numbers)] - path[frame], axis=1).max() <= 0.15
        assert sum(len(numbers) for numbers in tags.sighted.values()) > len(tags.places_m)


def test_the_plot_is_drawn(tmp_path):
    measured = {"online_relations_m": 0.12, "final_relations_m": 0.1, "tags": 65.0, "sightings": 110.0}
    rows = [
        kleiner_cellar._row(spacing, laser, [measured, measured | {"final_relations_m": 0.2}], 1.8)
        for laser in (False, True)
        for spacing in (1.0, 8.0, None)
    ]
    assert rows[0]["final_relations_m"] == pytest.approx(0.15)
    assert rows[0]["final_relations_sd_m"] == pytest.approx(0.05)
    assert (rows[0]["rbpf_relations_m"], rows[0]["graph_mapping_relations_m"]) == (0.070, 0.031)
    for column in kleiner_cellar.EXPERIMENT.columns:
        assert column.value in rows[0]
    path = tmp_path / "cellar.png"
    kleiner_cellar.EXPERIMENT.plot(rows, path)
    with Image.open(path) as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20
