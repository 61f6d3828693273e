"""The MRCLAM format: robots driven here without noise, odd and damaged files, and the real one."""

from dataclasses import fields, replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.datasets.mrclam import load
from robots.datasets.recording import RecordingError
from robots.evaluation import absolute_error
from robots.overrides import override
from robots.se2 import Pose2
from robots.trajectory import Trajectory

REAL = Path(__file__).parents[4] / "shared" / "data" / "mrclam6.npz"
LANDMARKS = {6: (2.0, 1.0), 7: (-1.0, 3.0), 20: (4.0, -2.0)}
START = Pose2(0.5, -0.2, 0.7)


def told(t_ms: np.ndarray) -> np.ndarray:
    """Velocities that change every so often, (n, 2)."""
    return np.column_stack([0.08 + 0.05 * np.sin(t_ms / 900.0), 0.4 * np.cos(t_ms / 1700.0)])


def drive(t_ms: np.ndarray, vw: np.ndarray, at_ms: float) -> Pose2:
    """The true pose of a robot that obeys 0.24 s late and goes 0.94 times as fast, step by step."""
    pose = START
    for begin, end, (v, w) in zip(t_ms + 240, [*(t_ms[1:] + 240), t_ms[-1] + 1340], vw, strict=True):
        held = max(0.0, min(at_ms, end) - begin) / 1e3
        pose = pose @ Pose2.exp(0.94 * np.array([v * held, 0.0, w * held]))
    return pose


def one_robot(number: int = 1) -> dict[str, np.ndarray]:
    return {name: array.copy() for name, array in _driven(number).items()}


@lru_cache
def _driven(number: int) -> dict[str, np.ndarray]:
    t_ms = np.cumsum([1000, *([10, 20, 40, 10, 300, 10] * 20)])
    vw = told(t_ms)
    seen_ms = np.arange(t_ms[0] + 500, t_ms[-1], 700)
    subjects = np.resize([6, 7, 20, 2, -1, 6], len(seen_ms))
    seen = []
    for at, subject in zip(seen_ms, subjects, strict=True):
        base = drive(t_ms, vw, at - 40)
        x, y = base.inverse().transform_point(*LANDMARKS.get(int(subject), (1.0, 1.0)))
        bearing = np.arctan2(y, x)
        depth = max(np.cos(bearing), 0.17)  # of the range, as the cameras measure it; these see all round
        seen.append([depth * (1.025 * np.hypot(x, y) + 0.04), bearing])
    truth_ms = np.arange(t_ms[0] + 240, t_ms[-1] + 240, 50)
    truth = [drive(t_ms, vw, at).as_array() for at in truth_ms]
    return {
        f"odo{number}_t_ms": t_ms,
        f"odo{number}_vw": vw,
        f"meas{number}_t_ms": seen_ms,
        f"meas{number}_subject": subjects,
        f"meas{number}_rb": np.array(seen),
        f"gt{number}_t_ms": truth_ms,
        f"gt{number}_xyth": np.array(truth),
    }


def write(folder: Path, **changes: np.ndarray | None) -> Path:
    path = folder / "recording.npz"
    content = {**one_robot(), **changes}
    np.savez(path, **{name: array for name, array in content.items() if array is not None})
    return path


def chain(recording, robot_id: str) -> np.ndarray:
    pose, poses = START, []
    for observation in recording.observations(robot_id):
        motion = observation.odometry
        pose = pose @ Pose2(motion.dx_m, motion.dy_m, motion.dtheta_rad)
        poses.append(pose.as_array())
    return np.array(poses)


def test_without_noise_odometry_and_sightings_are_exact(tmp_path):
    recording = load(write(tmp_path))
    arrays = one_robot()
    stamps, poses = recording.stamps_s("r1"), chain(recording, "r1")
    sightings = 0
    for stamp, pose, observation in zip(stamps, poses, recording.observations("r1"), strict=True):
        true = drive(arrays["odo1_t_ms"], arrays["odo1_vw"], stamp * 1e3)
        assert pose == pytest.approx(true.as_array(), abs=1e-9)
        for seen in observation.tag_sightings:
            x, y = seen.range_m * np.cos(seen.bearing_rad), seen.range_m * np.sin(seen.bearing_rad)
            place = true.transform_point(x, y)
            assert place == pytest.approx(LANDMARKS[int(seen.tag_id.removeprefix("L"))], abs=1e-9)
            sightings += 1
    assert sightings == np.isin(arrays["meas1_subject"], list(LANDMARKS)).sum() > 5


def test_robots_are_seen_by_name_and_what_was_not_read_is_left_out(tmp_path):
    observations = list(load(write(tmp_path)).observations("r1"))
    assert {seen.robot_id for o in observations for seen in o.robot_sightings} == {"r2"}
    assert {seen.tag_id for o in observations for seen in o.tag_sightings} == {"L6", "L7", "L20"}


def test_observations_are_merged_to_twenty_a_second_but_for_sightings(tmp_path):
    recording = load(write(tmp_path))
    seen_s = (one_robot()["meas1_t_ms"][one_robot()["meas1_subject"] > 0] - 40) / 1e3
    plain = [o.stamp_s for o in recording.observations("r1") if o.stamp_s not in seen_s][:-1]
    assert min(b - a for a, b in pairwise(plain)) > 0.0499
    assert set(seen_s) <= set(recording.stamps_s("r1"))
    assert [o.seq for o in recording.observations("r1")] == list(range(recording.length("r1")))


def test_by_range_only_there_are_no_bearings_and_no_robots(tmp_path):
    plain = load(write(tmp_path))
    for told, less in zip(
        plain.observations("r1"), replace(plain, range_only=True).observations("r1"), strict=True
    ):
        assert [s.range_m for s in less.tag_sightings] == [s.range_m for s in told.tag_sightings]
        assert all(s.bearing_rad is None for s in less.tag_sightings)
        assert less.robot_sightings == ()
    assert replace(plain, range_only=True).settings_of("r1")["slam"] == "rslam"


def test_every_robot_of_the_file_is_there_with_its_truth(tmp_path):
    recording = load(write(tmp_path, **one_robot(3), **{**one_robot(4), "gt4_t_ms": None}))
    assert recording.robots == ("r1", "r3", "r4")
    assert recording.truth("r4") is None
    truth = recording.truth("r3")
    poses = Trajectory(recording.stamps_s("r3"), chain(recording, "r3"))
    assert absolute_error(poses, truth, recording.truth_gap_s).rmse_m < 1e-3


def test_landmarks_are_known_where_the_file_has_them(tmp_path):
    assert load(write(tmp_path)).tag_places() == {}
    rows = np.array([[6, 2.0, 1.0, 0.0, 0.0], [7, np.nan, 3.0, 0.0, 0.0], [20, 4.0, -2.0, 0.1, 0.1]])
    assert load(write(tmp_path, landmarks=rows)).tag_places() == {"L6": (2.0, 1.0), "L20": (4.0, -2.0)}
    with pytest.raises(RecordingError, match="'landmarks' has shape"):
        load(write(tmp_path, landmarks=rows[:, :3]))


def test_the_settings_fit_the_agent(tmp_path):
    config = override(AgentConfig(), load(write(tmp_path)).settings)
    assert config.deployment.magazine == 0
    assert config.ranging.range_sd_per_m == 0.02


def agent_survives(recording) -> bool:
    agent = RobotAgent("r1", override(AgentConfig(), recording.settings))
    for observation in recording.observations("r1"):
        update = agent.step(observation)
    return bool(np.isfinite(update.pose.as_array()).all())


def test_velocities_are_not_held_through_a_gap_of_minutes(tmp_path):
    late = one_robot()["odo1_t_ms"] + np.where(np.arange(121) >= 60, 600_000, 0)
    recording = load(write(tmp_path, odo1_t_ms=late, meas1_t_ms=one_robot()["meas1_t_ms"]))
    stamps = recording.stamps_s("r1")
    gap = int(np.argmax(np.diff(stamps)))
    assert np.diff(stamps)[gap] > 590.0
    moved = np.diff(chain(recording, "r1")[:, :2], axis=0)[gap]
    assert np.hypot(*moved) <= 0.13 * 1.1
    assert agent_survives(recording)


def test_reversed_stamps_are_put_in_order(tmp_path):
    arrays = one_robot()
    order = np.arange(len(arrays["odo1_t_ms"]))
    order[[10, 30, 31]] = order[[31, 10, 30]]
    back = load(
        write(
            tmp_path,
            odo1_t_ms=arrays["odo1_t_ms"][order],
            odo1_vw=arrays["odo1_vw"][order],
            **{name: arrays[name][::-1] for name in ("meas1_t_ms", "meas1_subject", "meas1_rb")},
        )
    )
    plain = load(write(tmp_path))
    for ours, theirs in zip(back.observations("r1"), plain.observations("r1"), strict=True):
        assert ours == theirs or all(
            getattr(ours, item.name) == getattr(theirs, item.name) for item in fields(ours)
        )


def test_a_stamp_far_in_the_future_costs_a_gap_and_no_more(tmp_path):
    times = one_robot()["odo1_t_ms"].astype(np.int64)
    times[20] = 2**60
    recording = load(write(tmp_path, odo1_t_ms=times))
    assert recording.length("r1") < 200
    assert agent_survives(recording)


def test_ids_never_seen_are_tags_and_the_robots_own_is_left_out(tmp_path):
    odd = np.resize([32_767, 1, 0, -7, 21], len(one_robot()["meas1_t_ms"])).astype(np.int16)
    recording = load(write(tmp_path, meas1_subject=odd))
    observations = list(recording.observations("r1"))
    assert {seen.tag_id for o in observations for seen in o.tag_sightings} == {"L32767", "L21"}
    assert not any(o.robot_sightings for o in observations)
    assert agent_survives(recording)


def test_a_robot_that_saw_nothing_is_there(tmp_path):
    nothing = {"meas1_t_ms": np.zeros(0), "meas1_subject": np.zeros(0), "meas1_rb": np.zeros((0, 2))}
    recording = load(write(tmp_path, **nothing, gt1_t_ms=np.zeros(0), gt1_xyth=np.zeros((0, 3))))
    assert recording.length("r1") > 40
    assert recording.truth("r1") is None


WRONG = {
    "no robot": ({"odo1_t_ms": None}, "has no array 'odo1_t_ms'; it holds odo1_vw"),
    "no velocities": ({"odo1_vw": None}, "has no array 'odo1_vw'"),
    "no subjects": ({"meas1_subject": None}, "has no array 'meas1_subject'"),
    "no truth": ({"gt1_xyth": None}, "has no array 'gt1_xyth'"),
    "empty": ({"odo1_t_ms": np.zeros(0), "odo1_vw": np.zeros((0, 2))}, "'odo1_t_ms' is empty"),
    "shape": ({"odo1_vw": np.zeros((121, 3))}, r"'odo1_vw' has shape \(121, 3\), expected \(121, 2\)"),
    "lengths": ({"meas1_subject": np.zeros(2)}, "'meas1_subject' has shape"),
    "velocity": ({"odo1_vw": np.full((121, 2), np.nan)}, "'odo1_vw' holds a value that is not finite"),
    "stamp": ({"odo1_t_ms": np.full(121, np.inf)}, "'odo1_t_ms' holds a value that is not finite"),
    "text": ({"odo1_t_ms": np.array(["a"] * 121)}, "'odo1_t_ms' has to hold numbers"),
}


@pytest.mark.parametrize(("changes", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_array_is_named(tmp_path, changes, message):
    with pytest.raises(RecordingError, match=message):
        load(write(tmp_path, **changes))


@pytest.mark.parametrize(("place", "message"), [(np.nan, "not finite"), (-1.0, "ranges of 0 m or more")])
def test_a_wrong_sighting_is_named_unless_it_was_not_read(tmp_path, place, message):
    places, unread = one_robot()["meas1_rb"], one_robot()["meas1_subject"] == -1
    places[unread] = place
    assert load(write(tmp_path, meas1_rb=places)).length("r1") > 0
    places[0] = place
    with pytest.raises(RecordingError, match=f"'meas1_rb' (holds a value that is|has to hold) {message}"):
        load(write(tmp_path, meas1_rb=places))


def test_virtual_tags_are_refused_where_there_are_real_ones(tmp_path):
    with pytest.raises(RecordingError, match="mrclam has landmarks for tags"):
        load(write(tmp_path), 2.0)


@pytest.mark.data
@pytest.mark.skipif(not REAL.exists(), reason="the MRCLAM recording is not part of the project")
def test_the_real_recording():
    recording = load(REAL)
    assert recording.robots == ("r1", "r2", "r3", "r4", "r5")
    for robot_id in recording.robots:
        poses = Trajectory(recording.stamps_s(robot_id), chain(recording, robot_id))
        truth = recording.truth(robot_id)
        assert absolute_error(poses, truth, recording.truth_gap_s).rmse_m < 3.2
        assert recording.length(robot_id) > 10_000
    tags = {seen.tag_id for o in recording.observations("r3") for seen in o.tag_sightings}
    assert tags == {f"L{number}" for number in range(6, 21)}
