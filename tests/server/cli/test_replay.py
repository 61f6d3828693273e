"""`waymark replay`: a recording through the agent here, and to a server through the robot API."""

import json
from http.server import BaseHTTPRequestHandler, HTTPServer
from threading import Thread

import numpy as np
import pytest

from robots.se2 import Pose2
from robots.tum import read_tum
from server.cli.main import run


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Twice round a room of 12 x 8 m with a pillar; perfect wheels, laser and reference."""
    poses, angles = [], np.radians(-89.5 + np.arange(180))
    scanner = Pose2(0.0, -2.0, 0.0)
    motions = ([Pose2(0.4, 0.0, 0.0)] * 10 + [Pose2(0.2, 0.0, np.pi / 6)] * 3) * 8
    wheels = []
    for motion in motions:
        poses.append(scanner)
        scanner = scanner @ motion
        wheels.append((Pose2(0.095, 0.0, 0.0) @ motion @ Pose2(-0.095, 0.0, 0.0)).as_array())
    path = tmp_path_factory.mktemp("recording") / "loop.npz"
    np.savez(
        path,
        t_epoch=1000.0 + np.arange(len(poses)),
        ranges=np.array([_scan(pose, angles) for pose in poses], np.float32),
        odo_increments=np.array(wheels),
        corrected_pose=np.array([pose.as_array() for pose in poses]),
    )
    return path


@pytest.fixture(scope="module")
def team(tmp_path_factory):
    """Robots 1, 2 and 4 on circles among four landmarks; they turn 0.8 times as far as they were told."""
    arrays = {}
    for number in (1, 2, 4):
        t_ms = np.arange(0, 40_000, 100)
        seen, truth = [], []
        for at in t_ms:
            pose = Pose2(0.0, 0.1 * number, 0.0) @ Pose2.exp(np.array([0.25, 0.0, 0.16]) * 0.94 * at / 1e3)
            truth.append(pose.as_array())
            for k, place in enumerate([(3.0, 3.0), (-3.0, 3.0), (-3.0, -1.0), (3.0, -1.0)]):
                x, y = pose.inverse().transform_point(*place)
                bearing, range_m = np.arctan2(y, x), np.hypot(x, y)
                if at % 500 == 0 and x > 0.2 * range_m:
                    seen.append([at, 6 + k, np.cos(bearing) * (1.025 * range_m + 0.04), bearing])
        told = np.tile([0.25, 0.2], (len(t_ms), 1))
        arrays |= {f"odo{number}_t_ms": t_ms - 240, f"odo{number}_vw": told}
        rows = np.array(seen)
        arrays |= {f"meas{number}_t_ms": rows[:, 0] + 40, f"meas{number}_subject": rows[:, 1].astype(int)}
        arrays |= {f"meas{number}_rb": rows[:, 2:], f"gt{number}_t_ms": t_ms, f"gt{number}_xyth": truth}
    path = tmp_path_factory.mktemp("recording") / "team.npz"
    np.savez(path, **arrays)
    return path


def _scan(pose: Pose2, angles: np.ndarray) -> np.ndarray:
    """Ranges to the walls of the room and to a round pillar in its middle."""
    c, s = np.cos(pose.theta + angles), np.sin(pose.theta + angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(c > 0, (8.0 - pose.x) / c, (-4.0 - pose.x) / c)
        to_y = np.where(s > 0, (4.0 - pose.y) / s, (-4.0 - pose.y) / s)
    along = (1.5 - pose.x) * c + (0.3 - pose.y) * s
    across2 = (1.5 - pose.x) ** 2 + (0.3 - pose.y) ** 2 - along**2
    pillar = np.where(
        (along > 0) & (across2 < 0.25), along - np.sqrt(np.maximum(0.25 - across2, 0.0)), np.inf
    )
    return np.minimum(np.minimum(to_x, to_y), pillar)


def test_the_day_is_replayed_and_written(recording, tmp_path, capsys):
    arguments = ["replay", "intel", str(recording), "--virtual-tags", "2", "--out", str(tmp_path), "--json"]
    assert run(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["observations"] == 104
    assert result["ate_m"]["r1"] < 0.1
    assert result["sightings"] >= result["tags"] > 5
    assert result["tags_m"] < 0.2
    final = read_tum(tmp_path / "trajectory_r1_final.tum")
    assert final.stamps_s.tolist() == (1000.0 + np.arange(104)).tolist()
    tags = [row.split(",")[0] for row in (tmp_path / "tags.csv").read_text().splitlines()[1:]]
    assert set(tags) == {str(number + 1) for number in range(result["tags"])}
    assert (tmp_path / "map.png").exists()


def test_by_odometry_alone_the_graph_is_not_solved(team, tmp_path, capsys):
    """The wheels of this robot turn too far: only the landmarks can tell."""
    arguments = ["replay", "mrclam", str(team), "--robots", "r1", "--json"]
    assert run(arguments) == 0
    with_tags = json.loads(capsys.readouterr().out)
    assert run([*arguments, "--slam", "odometry"]) == 0
    without = json.loads(capsys.readouterr().out)
    assert (with_tags["slam"], without["slam"]) == ("tag-graph", "odometry")
    assert with_tags["sightings"] == without["sightings"] > 100
    assert without["ate_m"]["r1"] > 3.0 * with_tags["ate_m"]["r1"]


def test_a_filter_over_the_landmarks_beats_odometry(team, capsys):
    arguments = ["replay", "mrclam", str(team), "--robots", "r1", "--json", "--slam"]
    errors = {}
    for slam in ("ekf", "odometry"):
        assert run([*arguments, slam]) == 0
        errors[slam] = json.loads(capsys.readouterr().out)["ate_online_m"]["r1"]
    assert 3.0 * errors["ekf"] < errors["odometry"]


def test_later_robots_read_what_earlier_ones_left_in_the_tags(team, capsys):
    arguments = ["replay", "mrclam", str(team), "--slam", "ekf", "--no-robot-sightings", "--json"]
    errors = {}
    for memory in ("none", "tags"):
        assert run([*arguments, "--memory", memory]) == 0
        errors[memory] = json.loads(capsys.readouterr().out)["ate_online_m"]
    assert errors["tags"]["r1"] == errors["none"]["r1"]
    assert errors["tags"]["r4"] != errors["none"]["r4"]
    assert errors["tags"]["r4"] < 0.1


def test_by_range_alone_too_a_team_ends_with_its_joint_solution(team, capsys):
    arguments = ["replay", "mrclam", str(team), "--range-only", "--json"]
    errors = []
    for more in ([], ["--robots", "r1"]):
        assert run([*arguments, *more]) == 0
        errors.append(json.loads(capsys.readouterr().out))
    together, alone = errors
    assert together["ate_online_m"]["r1"] == alone["ate_online_m"]["r1"]
    assert together["ate_m"]["r1"] != alone["ate_m"]["r1"]


def test_robots_go_through_a_recording_in_the_order_asked_for(team, tmp_path, capsys):
    arguments = ["replay", "mrclam", str(team), "--order", "r4,r1", "--out", str(tmp_path), "--json"]
    assert run(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    assert list(result["ate_m"]) == ["r4", "r1", "r2"]
    assert run([*arguments, "--robots", "r2,r4"]) == 1
    assert "there is no robot 'r1'; there are r2, r4" in capsys.readouterr().err
    assert len(list(tmp_path.glob("trajectory_r?_final.tum"))) == 3


def test_a_pose_graph_is_replayed_and_written(tmp_path, capsys):
    path = tmp_path / "square.g2o"
    edges = [(k, k + 1) for k in range(8)] + [(0, 4), (4, 8)]
    turn = ["1 0 1.5707963", "0 0 6.2831853"]
    path.write_text("".join(f"EDGE_SE2 {i} {j} {turn[j - i > 1]} 100 0 0 100 0 100\n" for i, j in edges))
    assert run(["replay", "g2o", str(path), "--out", str(tmp_path / "out"), "--json"]) == 0
    shown = capsys.readouterr()
    result = json.loads(shown.out)
    assert (result["vertices"], result["edges"], result["loops"]) == (9, 10, 2)
    assert result["chi2"] == pytest.approx(0.0, abs=1e-6)
    assert shown.err.startswith("Note: vertices that only edges name were placed along them: 0, 1")
    assert len(read_tum(tmp_path / "out" / "trajectory_r1_final.tum")) == 9
    assert run(["solve", str(tmp_path / "out" / "solved.g2o"), "--json"]) == 0


def test_relations_are_compared_on_demand(recording, tmp_path, capsys):
    truth = np.load(recording)["corrected_pose"]
    rows = []
    for i, j in [(5, 57), (10, 40), (60, 9)]:
        motion = Pose2.from_array(truth[i]).between(Pose2.from_array(truth[j]))
        rows.append([1000.0 + i, 1000.0 + j, motion.x, motion.y, 0, 0, 0, motion.theta])
    np.savetxt(tmp_path / "loop.relations", rows)
    arguments = ["replay", "intel", str(recording), "--relations", str(tmp_path / "loop.relations"), "--json"]
    assert run(arguments) == 0
    assert json.loads(capsys.readouterr().out)["relations_m"]["r1"] < 0.1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["mars", "FILE"], "there is no dataset 'mars'; known are csail, g2o, intel, log, mrclam"),
        (["intel", "absent.npz"], "there is no recording absent.npz"),
        (["log", "FILE"], "is no mission log that waymark export wrote"),
        (["g2o", "absent.g2o"], "cannot read the graph absent.g2o"),
        (["g2o", "FILE"], "has no VERTEX_SE2 and no EDGE_SE2 line"),
        (["g2o", "FILE", "--robots", "1"], "a pose graph has no robots and no sensors"),
        (["intel", "FILE", "--virtual-tags", "0"], "--virtual-tags has to be greater than 0"),
        (["intel", "FILE", "--virtual-tags", "nan"], "--virtual-tags has to be a finite number"),
        (["intel", "FILE", "--speed", "-1"], "--speed has to be 0 or more"),
        (
            ["intel", "FILE", "--slam", "magic"],
            "--slam has to be tag-graph, ekf, rslam or odometry, not 'magic'",
        ),
        (["intel", "FILE", "--memory", "paper"], "--memory has to be none or tags, not 'paper'"),
        (["intel", "FILE", "--server", "ftp://x", "--memory", "tags"], "belong to a replay without --server"),
        (["g2o", "FILE", "--no-robot-sightings"], "a pose graph has no robots and no sensors"),
        (["intel", "FILE", "--robots", "2"], "--robots 2: the recording has 1: r1"),
        (["intel", "FILE", "--order", "r2"], "--order: there is no robot 'r2'; there are r1"),
        (["intel", "FILE", "--relations", "absent"], "cannot read the relations absent"),
        (["intel", "FILE", "--server", "ftp://x"], "is not the address of a server"),
        (
            ["intel", "FILE", "--server", "http://127.0.0.1:9", "--out", "OUT"],
            "belong to a replay without --server",
        ),
    ],
)
def test_what_cannot_be_replayed_ends_in_one_sentence(recording, tmp_path, capsys, arguments, words):
    paths = {"FILE": str(recording), "OUT": str(tmp_path)}
    assert run(["replay", *(paths.get(word, word) for word in arguments), "--json"]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert words in shown.err
    assert shown.err.count("\n") == 1


@pytest.fixture
def control():
    """A server that takes missions, robots and observations, and remembers them."""
    seen: dict[str, list] = {"missions": [], "robots": [], "batches": []}

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            kind = {"missions": "missions", "robots": "robots", "observations": "batches"}[
                self.path.split("/")[-1]
            ]
            seen[kind].append(body)
            posted = sum(len(batch["observations"]) for batch in seen["batches"])
            reply = json.dumps({"next_seq": posted, "stop": False, "command": {}}).encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(reply)))
            self.end_headers()
            self.wfile.write(reply)

        def log_message(self, *_: object) -> None:
            pass

    server = HTTPServer(("127.0.0.1", 0), Handler)
    thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02})
    thread.start()
    yield f"http://127.0.0.1:{server.server_address[1]}", seen
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_recording_is_posted_through_the_robot_api(recording, control, capsys):
    url, seen = control
    options = ["--virtual-tags", "2", "--server", url, "--speed", "0", "--mission", "day", "--json"]
    assert run(["replay", "intel", str(recording), *options]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["posted"], result["mission_id"]) == (104, "day")
    observations = [item for batch in seen["batches"] for item in batch["observations"]]
    assert [item["seq"] for item in observations] == list(range(104))
    assert seen["robots"][0]["config"]["antenna"]["radius_m"] == 0.15
    assert observations[0]["tag_sightings"] == [{"tag_id": "1", "memory": ""}]


def test_agents_on_a_server_are_told_how_to_estimate_too(team, control, capsys):
    url, seen = control
    options = ["--server", url, "--speed", "0", "--robots", "2", "--order", "r2", "--slam", "odometry"]
    assert run(["replay", "mrclam", str(team), *options, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["robots"] == 2
    assert [robot["robot_id"] for robot in seen["robots"]] == ["r2", "r1"]
    assert seen["robots"][0]["config"]["slam"] == "odometry"
    observed = [item for batch in seen["batches"] for item in batch["observations"]]
    assert any("range_m" in tag for item in observed for tag in item.get("tag_sightings", ()))


def test_the_speed_is_kept_and_a_second_call_goes_on(recording, control, capsys):
    url, _ = control
    arguments = ["replay", "intel", str(recording), "--server", url, "--mission", "day", "--json"]
    assert run([*arguments, "--speed", "100"]) == 0
    assert json.loads(capsys.readouterr().out)["wall_s"] > 0.9  # 103 s of recording, sent in groups
    assert run([*arguments, "--speed", "0"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["posted"] == 0
    assert "r1 goes on at observation 104" in shown.err
