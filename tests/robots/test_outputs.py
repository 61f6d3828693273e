"""What a run leaves in a folder, read back by other means than those that wrote it."""

import csv

import numpy as np
import pytest
import yaml
from PIL import Image

from robots.outputs import write_map, write_tags, write_trajectories
from robots.sim.map_files import load_map
from robots.team import TeamGrid, TeamTag
from robots.trajectory import Trajectory
from robots.tum import read_tum


def read_back(folder, free_thresh=None):
    """Classes -1, 0, 100 as map_server's trinary mode gives them, row 0 at the bottom."""
    fields = yaml.safe_load((folder / "map.yaml").read_text())
    grey = np.asarray(Image.open(folder / fields["image"]).convert("L")).astype(np.float32)
    p = (255.0 - grey) / 255.0 if not fields["negate"] else grey / 255.0
    free = np.float32(fields["free_thresh"] if free_thresh is None else free_thresh)
    classes = np.full(p.shape, -1)
    classes[p > np.float32(fields["occupied_thresh"])] = 100
    classes[p < free] = 0
    return classes[::-1], fields


@pytest.mark.parametrize("free_thresh", [None, 0.196])
def test_every_class_of_the_map_is_read_back(tmp_path, free_thresh):
    cells = np.full((4, 6), -1, np.int8)
    cells[1, 1:5] = [0, 49, 65, 100]
    cells[2, 3] = 57  # seen, but equivocal
    write_map(tmp_path, TeamGrid(cells, (-1.5, 2.25), 0.05, 1))
    classes, fields = read_back(tmp_path, free_thresh)
    expected = np.full((4, 6), -1)
    expected[1, 1:5] = [0, 0, 100, 100]
    assert classes.tolist() == expected.tolist()
    assert fields["origin"] == [-1.5, 2.25, 0.0]
    assert fields["resolution"] == 0.05
    assert fields["mode"] == "trinary"


def test_the_simulator_drives_in_a_map_that_was_written(tmp_path):
    cells = np.full((20, 30), -1, np.int8)
    cells[5:15, 5:25] = 0
    cells[5, 5:25] = 100
    write_map(tmp_path, TeamGrid(cells, (0.0, 0.0), 0.05, 1))
    world = load_map(tmp_path / "map.yaml")
    assert world.free[1:-1, 1:-1].tolist() == (cells == 0).tolist()  # a rim of wall is put round every map


def test_without_a_grid_the_map_is_one_unknown_cell(tmp_path):
    write_map(tmp_path / "new", None)
    classes, _ = read_back(tmp_path / "new")
    assert classes.tolist() == [[-1]]


def test_tags_are_written_with_their_covariance(tmp_path):
    write_tags(tmp_path, [TeamTag("17", 1.25, -3.5, np.array([[0.01, 0.002], [0.002, 0.04]]), 3, ("r1",))])
    rows = list(csv.DictReader((tmp_path / "tags.csv").read_text().splitlines()))
    assert rows == [
        {
            "tag_id": "17",
            "x_m": "1.250000",
            "y_m": "-3.500000",
            "var_x": "0.01",
            "var_xy": "0.002",
            "var_y": "0.04",
        }
    ]


def test_both_trajectories_of_a_robot_are_written(tmp_path):
    online = Trajectory(np.array([0.0, 1.0]), np.zeros((2, 3)))
    final = Trajectory(np.array([0.0, 1.0]), np.ones((2, 3)))
    write_trajectories(tmp_path / "out", "r1", online, final)
    assert read_tum(tmp_path / "out" / "trajectory_r1.tum").poses[0].tolist() == [0.0, 0.0, 0.0]
    assert read_tum(tmp_path / "out" / "trajectory_r1_final.tum").poses[0] == pytest.approx(np.ones(3))
