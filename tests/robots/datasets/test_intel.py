"""The Intel format: a small recording written here, damaged files, and the real one where it is at hand."""

from itertools import pairwise
from math import radians
from pathlib import Path

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.datasets import registry
from robots.datasets.intel import load
from robots.datasets.recording import RecordingError
from robots.overrides import override
from robots.se2 import Pose2

REAL = Path(__file__).parents[4] / "shared" / "data" / "intel_raw_2726.npz"
SCANNER = Pose2(0.095, 0.0, 0.0)


def arrays(n: int = 6) -> dict[str, np.ndarray]:
    return {
        "t_epoch": np.array([np.nan, 10.0, 11.0, 10.9, 12.0, 13.0][:n]),
        "ranges": np.where(np.arange(180) < 90, 5.0, 81.83).astype(np.float32) * np.ones((n, 1), np.float32),
        "odo_increments": np.tile([0.3, 0.0, 0.1], (n, 1)),
        "corrected_pose": np.column_stack([np.arange(n) * 0.3, np.zeros(n), np.zeros(n)]),
    }


def write(folder: Path, **changes: np.ndarray | None) -> Path:
    path = folder / "recording.npz"
    content = {**arrays(), **changes}
    np.savez(path, **{name: array for name, array in content.items() if array is not None})
    return path


def test_frames_become_observations_in_order(tmp_path):
    recording = load(write(tmp_path))
    observations = list(recording.observations("r1"))
    assert [observation.seq for observation in observations] == list(range(5))  # frame 0 has no stamp
    assert [observation.stamp_s for observation in observations] == [10.0, 11.0, 11.0, 12.0, 13.0]
    assert recording.stamps_s("r1").tolist() == [10.0, 11.0, 10.9, 12.0, 13.0]
    assert recording.length("r1") == 5
    assert recording.robots == ("r1",)


def test_row_k_is_the_motion_to_frame_k_plus_1_carried_over_to_the_scanner(tmp_path):
    increments = np.array(
        [[9.0, 9.0, 9.0], [0.3, 0.0, 0.1], [0.2, 0.01, -0.4], [0.0, 0.0, 0.5], [0.1, 0.0, 0.0]]
    )
    increments = np.vstack([increments, [7.0, 7.0, 7.0]])  # the motion after the last frame
    motions = [o.odometry for o in load(write(tmp_path, odo_increments=increments)).observations("r1")]
    assert (motions[0].dx_m, motions[0].dy_m, motions[0].dtheta_rad) == (0.0, 0.0, 0.0)
    wheels, scanner = Pose2(), Pose2()
    for row, motion in zip(increments[1:5], motions[1:], strict=True):
        wheels = wheels @ Pose2.from_array(row)
        scanner = scanner @ Pose2(motion.dx_m, motion.dy_m, motion.dtheta_rad)
    expected = SCANNER.inverse() @ wheels @ SCANNER
    assert scanner.as_array() == pytest.approx(expected.as_array())


def test_a_frame_without_a_stamp_hands_its_motion_on(tmp_path):
    stamps = np.array([9.0, 10.0, np.nan, 11.0, 12.0, 13.0])
    increments = np.tile([0.3, 0.0, 0.0], (6, 1))
    observations = list(load(write(tmp_path, t_epoch=stamps, odo_increments=increments)).observations("r1"))
    assert [round(o.odometry.dx_m, 6) for o in observations] == [0.0, 0.3, 0.6, 0.3, 0.3]


def test_beams_are_centred_and_a_degree_apart_and_no_echo_is_a_far_reading(tmp_path):
    scan = next(iter(load(write(tmp_path)).observations("r1"))).scan
    assert scan.angle_min_rad == pytest.approx(radians(-89.5))
    assert scan.angle_increment_rad == pytest.approx(radians(1.0))
    assert (scan.ranges_m >= scan.range_max_m).tolist() == [False] * 90 + [True] * 90


def test_virtual_tags_are_sighted_by_number_only(tmp_path):
    observations = list(load(write(tmp_path), 0.5).observations("r1"))
    sighted = [[(tag.tag_id, tag.memory) for tag in o.tag_sightings] for o in observations]
    assert sighted == [[("1", b"")], [], [("2", b"")], [], [("3", b"")]]


def test_the_settings_fit_the_agent(tmp_path):
    config = override(AgentConfig(), load(write(tmp_path)).settings)
    assert config.antenna.radius_m == 0.15
    assert config.deployment.magazine == 0


def test_the_truth_is_the_reference_path(tmp_path):
    truth = load(write(tmp_path)).truth("r1")
    assert truth.stamps_s.tolist() == [10.0, 11.0, 10.9, 12.0, 13.0]
    assert truth.poses[:, 0] == pytest.approx([0.3, 0.6, 0.9, 1.2, 1.5])
    assert load(write(tmp_path, corrected_pose=np.full((6, 3), np.nan))).truth("r1") is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ranges": None}, "has no array 'ranges'; it holds"),
        (
            {"ranges": np.zeros((6, 361), np.float32)},
            r"array 'ranges' has shape \(6, 361\), expected \(6, 180\)",
        ),
        (
            {"odo_increments": np.zeros((5, 3))},
            r"array 'odo_increments' has shape \(5, 3\), expected \(6, 3\)",
        ),
        ({"t_epoch": np.array(["a"] * 6)}, "array 't_epoch' has to hold numbers"),
        ({"t_epoch": np.array(3.0)}, "array 't_epoch' has shape"),
        ({"t_epoch": np.full(6, np.nan)}, "'t_epoch' holds fewer than two stamps"),
        ({"odo_increments": np.full((6, 3), np.inf)}, "'odo_increments' holds a value that is not finite"),
        ({"ranges": np.full((6, 180), -1.0, np.float32)}, "'ranges' has to hold distances"),
        ({"t_epoch": np.array([None] * 6, dtype=object)}, "is not an intact .npz recording"),
    ],
)
def test_a_wrong_array_is_named(tmp_path, changes, message):
    with pytest.raises(RecordingError, match=message):
        load(write(tmp_path, **changes))


def test_virtual_tags_need_a_reference(tmp_path):
    with pytest.raises(RecordingError, match="'corrected_pose' holds no pose"):
        load(write(tmp_path, corrected_pose=np.full((6, 3), np.nan)), 2.0)


def test_a_file_that_is_missing_cut_short_or_something_else_is_named(tmp_path):
    with pytest.raises(RecordingError, match="there is no recording"):
        load(tmp_path / "absent.npz")
    with pytest.raises(RecordingError, match="cannot read the recording"):
        load(tmp_path)
    whole = write(tmp_path).read_bytes()
    for name, data in {"short": whole[: len(whole) // 2], "text": b"hello", "empty": b""}.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(RecordingError, match=f"{name} is not an intact .npz recording"):
            load(tmp_path / name)
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(RecordingError, match="is a single array"):
        load(tmp_path / "one.npy")


def test_the_registry_names_what_it_knows(tmp_path):
    assert registry.load("intel", write(tmp_path)).name == "intel"
    with pytest.raises(RecordingError, match="no dataset 'mars'; known are csail, g2o, intel, log, mrclam"):
        registry.load("mars", write(tmp_path))


@pytest.mark.data
@pytest.mark.skipif(not REAL.exists(), reason="the Intel recording is not part of the project")
def test_the_real_recording():
    recording = load(REAL, 2.0)
    observations = list(recording.observations("r1"))
    assert len(observations) == 2725
    turned = sum(abs(o.odometry.dtheta_rad) for o in observations)
    assert turned == pytest.approx(326.0, rel=0.001)  # the same for wheels and scanner
    far = np.mean([np.mean(o.scan.ranges_m >= o.scan.range_max_m) for o in observations])
    assert far == pytest.approx(0.028, abs=0.001)
    assert all(b.stamp_s >= a.stamp_s for a, b in pairwise(observations))
    tags = [tag.tag_id for o in observations for tag in o.tag_sightings]
    assert len(set(tags)) > 50
    assert len(tags) > 1.5 * len(set(tags))  # places are passed again
