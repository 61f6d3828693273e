"""The CSAIL format: a small recording written here, odd and damaged files, and the real one."""

from itertools import pairwise
from math import radians
from pathlib import Path

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.datasets.csail import load
from robots.datasets.recording import RecordingError
from robots.overrides import override
from robots.se2 import Pose2

REAL = Path(__file__).parents[4] / "shared" / "data" / "csail_406.npz"
SCANNER = Pose2(0.0, 0.0, 0.0186)


def arrays(n: int = 6) -> dict[str, np.ndarray]:
    k = np.arange(n)
    return {
        "t_epoch": 10.0 + 0.9 * k,
        "ranges": np.where(np.arange(361) < 180, 5.0, 81.91).astype(np.float32) * np.ones((n, 1), np.float32),
        "raw_odometry_pose": np.column_stack([500.0 + 0.8 * k, 0.1 * k**2, -1.0 + 0.6 * k]),
        "corrected_pose": np.column_stack([0.5 * k, np.zeros(n), np.zeros(n)]),
    }


def write(folder: Path, **changes: np.ndarray | None) -> Path:
    path = folder / "recording.npz"
    content = {**arrays(), **changes}
    np.savez(path, **{name: array for name, array in content.items() if array is not None})
    return path


def driven(recording) -> list[np.ndarray]:
    pose, poses = Pose2(), []
    for observation in recording.observations("r1"):
        motion = observation.odometry
        pose = pose @ Pose2(motion.dx_m, motion.dy_m, motion.dtheta_rad)
        poses.append(pose.as_array())
    return poses


def test_the_poses_of_the_wheels_become_displacements_of_the_scanner(tmp_path):
    wheels = [Pose2.from_array(row) for row in arrays()["raw_odometry_pose"]]
    for pose, here in zip(driven(load(write(tmp_path))), wheels, strict=True):
        expected = (wheels[0] @ SCANNER).between(here @ SCANNER)
        assert pose == pytest.approx(expected.as_array())


def test_a_frame_without_a_stamp_hands_its_motion_on(tmp_path):
    stamps = arrays()["t_epoch"]
    stamps[2] = np.nan
    poses, every = driven(load(write(tmp_path, t_epoch=stamps))), driven(load(write(tmp_path)))
    assert np.array(poses) == pytest.approx(np.delete(np.array(every), 2, axis=0))


def test_beams_are_half_a_degree_apart_and_no_echo_is_a_far_reading(tmp_path):
    scan = next(iter(load(write(tmp_path)).observations("r1"))).scan
    assert scan.angle_min_rad == pytest.approx(radians(-90.0))
    assert scan.angle_min_rad + 360 * scan.angle_increment_rad == pytest.approx(radians(90.0))
    assert (scan.ranges_m >= scan.range_max_m).tolist() == [False] * 180 + [True] * 181


def test_virtual_tags_and_settings(tmp_path):
    recording = load(write(tmp_path), 1.0)
    sighted = [[tag.tag_id for tag in o.tag_sightings] for o in recording.observations("r1")]
    assert sighted == [["1"], [], ["2"], [], ["3"], []]
    assert recording.tag_places() == {"1": (0.0, 0.0), "2": (1.0, 0.0), "3": (2.0, 0.0)}
    assert override(AgentConfig(), recording.settings).antenna.radius_m == 0.15


def test_stamps_that_run_back_or_leap_are_survived(tmp_path):
    stamps = np.array([10.0, 9.0, 11.0, 4000.0, 3999.0, 4001.0])
    recording = load(write(tmp_path, t_epoch=stamps))
    observed = [o.stamp_s for o in recording.observations("r1")]
    assert observed == [10.0, 10.0, 11.0, 4000.0, 4000.0, 4001.0]
    assert recording.stamps_s("r1").tolist() == stamps.tolist()


WRONG = {
    "missing": ({"raw_odometry_pose": None}, "has no array 'raw_odometry_pose'"),
    "beams": ({"ranges": np.zeros((6, 180))}, r"'ranges' has shape \(6, 180\), expected \(6, 361\)"),
    "empty": ({name: array[:0] for name, array in arrays().items()}, "'t_epoch' holds fewer than two stamps"),
    "not a number": ({"raw_odometry_pose": np.full((6, 3), np.nan)}, "'raw_odometry_pose' holds a value"),
    "negative": ({"ranges": np.full((6, 361), -2.0)}, "'ranges' has to hold distances of 0 m or more"),
    "no distance": ({"ranges": np.full((6, 361), np.nan)}, "'ranges' has to hold distances of 0 m or more"),
}


@pytest.mark.parametrize(("changes", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_array_is_named(tmp_path, changes, message):
    with pytest.raises(RecordingError, match=message):
        load(write(tmp_path, **changes))


@pytest.mark.data
@pytest.mark.skipif(not REAL.exists(), reason="the CSAIL recording is not part of the project")
def test_the_real_recording():
    recording = load(REAL, 2.0)
    observations = list(recording.observations("r1"))
    assert len(observations) == 406
    assert all(b.stamp_s >= a.stamp_s for a, b in pairwise(observations))
    far = np.mean([np.mean(o.scan.ranges_m >= o.scan.range_max_m) for o in observations])
    assert far == pytest.approx(0.027, abs=0.001)
    truth = recording.truth("r1").poses
    motions = [(o.odometry.dx_m, o.odometry.dy_m) for o in observations[1:]]
    true = [Pose2.from_array(a).between(Pose2.from_array(b)) for a, b in pairwise(truth)]
    errors = np.array(motions) - [(pose.x, pose.y) for pose in true]
    assert np.median(np.hypot(*errors.T)) < 0.06
