"""TUM trajectory files: what is written is read again; what is wrong is named by its line."""

import numpy as np
import pytest

from robots.trajectory import Trajectory
from robots.tum import TumError, read_tum, write_tum


def test_what_is_written_is_read_again(tmp_path):
    rng = np.random.default_rng(1)
    stamps = 976_052_857.0 + np.cumsum(rng.uniform(0.1, 1.0, 50))
    poses = np.column_stack([rng.uniform(-30, 30, (50, 2)), rng.uniform(-np.pi, np.pi, 50)])
    write_tum(tmp_path / "t.tum", Trajectory(stamps, poses))
    again = read_tum(tmp_path / "t.tum")
    assert again.stamps_s == pytest.approx(stamps, abs=1e-6)
    assert again.poses == pytest.approx(poses, abs=2e-6)


def test_poses_without_a_stamp_are_left_out(tmp_path):
    write_tum(tmp_path / "t.tum", Trajectory(np.array([np.nan, 1.0]), np.zeros((2, 3))))
    assert (tmp_path / "t.tum").read_text() == "1.000000 0.000000 0.000000 0 0 0 0.000000000 1.000000000\n"


def test_comments_blank_lines_and_lines_that_are_not_finite_are_passed_over(tmp_path):
    (tmp_path / "t.tum").write_text(
        "# stamp x y\n\n1 2 3 0 0 0 0 1 # end\nnan 2 3 0 0 0 0 1\n2 2 inf 0 0 0 0 1\n"
    )
    assert read_tum(tmp_path / "t.tum").poses.tolist() == [[2.0, 3.0, 0.0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3 0 0 0 0 1\n1 2 3\n", "t.tum, line 2: expected eight numbers"),
        ("1 2 3 0 0 0 0 1\n\n1 2 x 0 0 0 0 1\n", "t.tum, line 3: every word has to be a number"),
        ("# only words\n", "t.tum holds no pose"),
        ("", "t.tum holds no pose"),
    ],
)
def test_a_damaged_file_is_named_with_its_line(tmp_path, text, message):
    (tmp_path / "t.tum").write_text(text)
    with pytest.raises(TumError, match=message):
        read_tum(tmp_path / "t.tum")


def test_a_file_that_is_missing_or_not_text_is_named(tmp_path):
    with pytest.raises(TumError, match=r"absent\.tum: No such file"):
        read_tum(tmp_path / "absent.tum")
    (tmp_path / "t.tum").write_bytes(b"\x89PNG\xff\xfe\x00")
    with pytest.raises(TumError, match="not a text file"):
        read_tum(tmp_path / "t.tum")
