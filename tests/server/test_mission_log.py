"""The story of a log: a mission through the real server, exported, replayed elsewhere, bit for bit."""

import gzip
import json
import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest

from robots import codec
from robots.datasets.log_lines import LineWriter, read_lines
from robots.types import Observation
from server.cli.main import run

BATCHES = 60


def lines_of(path):
    return gzip.decompress(path.read_bytes()).splitlines()


@pytest.fixture
def ended(tmp_path, make_control, drive, wait_until):
    """The folder of a mission control that was ended after a mission: r1 drove, r2 never sent a thing."""
    line = make_control(tmp_path / "data", snapshot_every=30, reply_s=120.0).open("school")
    line.register(**line.words)
    line.register("r2")
    for wires in drive.wires[:BATCHES]:
        line.send(wires)
    wait_until(lambda: line.control.sql("SELECT seq FROM agent_snapshots WHERE seq > 100"))
    line.control.stop()
    return tmp_path / "data"


def test_a_mission_is_exported_and_replayed_bit_for_bit(ended, tmp_path, capsys):
    out = tmp_path / "school.log"
    assert run(["export", "log", "school", "--data", str(ended), "--out", str(out), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert (result["mission_id"], result["bytes"]) == ("school", out.stat().st_size)
    lines = lines_of(out)
    head = json.loads(lines[0])
    assert (head["waymark_log"], head["name"], head["robots"]) == (1, "SCHOOL", 2)
    with closing(sqlite3.connect(ended / "waymark.db")) as database:
        stored = [row[0] for row in database.execute("SELECT body FROM observations ORDER BY seq")]
    assert lines[2:-2] == stored
    assert len(stored) == 4 * BATCHES
    assert json.loads(lines[-2])["observations"] == 0

    assert run(["replay", "log", str(out), "--out", str(tmp_path / "maps"), "--json"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["bit_equal"] == {"r1": True}
    assert replayed["updates_compared"]["r1"] > 100
    assert (replayed["observations"], replayed["refused"]) == (4 * BATCHES, 0)
    assert (tmp_path / "maps" / "trajectory_r1_final.tum").exists()

    assert run(["replay", "log", str(out), "--slam", "odometry", "--json"]) == 0
    assert "bit_equal" not in json.loads(capsys.readouterr().out)  # it was told otherwise

    changed = tmp_path / "changed.log"
    writer, pieces = LineWriter(), []
    for number, data in enumerate(read_lines(out)):
        if number == 100:
            observation = codec.decode(data, Observation)
            wheels = replace(observation.odometry, front_left_m=observation.odometry.front_left_m + 1e-9)
            data = codec.encode(replace(observation, odometry=wheels))
        pieces.append(writer.line(data.rstrip(b"\n")))
    changed.write_bytes(b"".join([*pieces, writer.end()]))
    assert run(["replay", "log", str(changed), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["bit_equal"] == {"r1": False}


def test_a_running_mission_control_gives_the_log_too(driven, drive, tmp_path, capsys):
    out = tmp_path / "driven.log"
    url = f"http://127.0.0.1:{driven.control.port}"
    assert run(["export", "log", "driven", "--server", url, "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["lines"] == 2 + sum(map(len, drive.batches))
    assert gzip.decompress(driven.call("GET", "/log").content).splitlines() == lines_of(out)
    assert run(["replay", "log", str(out), "--json"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["bit_equal"] == {"r1": True}


def test_a_log_posted_to_another_mission_control_becomes_the_same_log(ended, control, tmp_path, capsys):
    first, second = tmp_path / "first.log", tmp_path / "second.log"
    url = f"http://127.0.0.1:{control.port}"
    assert run(["export", "log", "school", "--data", str(ended), "--out", str(first)]) == 0
    post = ["--server", url, "--speed", "0", "--mission", "school-again"]
    assert run(["replay", "log", str(first), *post]) == 0
    assert run(["export", "log", "school-again", "--server", url, "--out", str(second)]) == 0
    ours, theirs = lines_of(first), lines_of(second)
    assert ours[2:-2] == theirs[2:-1]  # r2 had nothing to post
    told, told_again = json.loads(ours[1]), json.loads(theirs[1])
    for name in ("robot_id", "start_pose", "config", "observations"):
        assert told[name] == told_again[name]
    # the tags in it bear the first mission's seal: under another the server would take them for a stranger's
    [(key,)] = control.sql("SELECT tag_key FROM missions WHERE mission_id = 'school-again'")
    assert key == told["config"]["tag_memory"]["key"]


def test_what_cannot_be_exported_ends_in_one_sentence(ended, control, tmp_path, capsys):
    url = f"http://127.0.0.1:{control.port}"
    out = ["--out", str(tmp_path / "x.log")]
    data = ["--data", str(ended)]
    for arguments, words in [
        (["map", "school", *data, *out], "waymark export writes a log, not 'map'"),
        (["log", "castle", *data, *out], "there is no mission 'castle' in"),
        (["log", "school", "--data", str(tmp_path / "nowhere"), *out], "there is no database"),
        (["log", "school", *data, "--out", str(tmp_path / "no" / "x.log")], "cannot be written"),
        (["log", "school", *data, "--server", url, *out], "leave them out"),
        (["log", "castle", "--server", url, *out], "There is no mission 'castle'"),
        (["log", "school", "--server", "http://127.0.0.1:9", *out], "cannot be reached"),
        (["log", "school", "--server", "ftp://x", *out], "is not the address of a server"),
        (["log", "x", "--data", str(control.settings.data_dir), *out], "in use by another Waymark server"),
    ]:
        assert run(["export", *arguments, "--json"]) == 1, arguments
        shown = capsys.readouterr()
        assert shown.out == ""
        assert words in shown.err
        assert shown.err.count("\n") == 1
    assert not list(tmp_path.glob("x.log*"))


def test_observations_that_no_agent_survives_are_marked(ended, tmp_path, capsys, make_control):
    control = make_control(ended, snapshot_every=1000)
    control.sql("UPDATE observations SET fault = 'it died' WHERE seq = 200")
    control.stop()
    out = tmp_path / "school.log"
    assert run(["export", "log", "school", "--data", str(ended), "--out", str(out)]) == 0
    lines = lines_of(out)
    at = lines.index(b'{"fault":"it died"}')
    assert codec.decode(lines[at + 1], Observation).seq == 200
    capsys.readouterr()
    assert run(["replay", "log", str(out), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["observations"] == 4 * BATCHES
