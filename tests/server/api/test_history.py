"""A mission's past through the API: it tells what the stream showed, also after a restart."""

import gzip
import io
import json
import time
from uuid import uuid4

from PIL import Image

QUICK = ("victim", "alert", "event", "annotation", "evacuation", "orders")  # recorded at the next tick

SLOW = ("trail", "tag", "links", "map")


def at(line, unix_s):
    return line.get(f"/history/state?unix_s={unix_s:.3f}")["state"]


def slow(state):
    return {key: value for key, value in state.items() if key.partition("/")[0] in SLOW}


def quick(state):
    return {key: value for key, value in state.items() if key.partition("/")[0] in QUICK}


def replayed(line, number):
    """A chunk as a browser reads it: times, and the state after each of them."""
    chunk = line.get(f"/history/chunks/{number}")
    state = chunk["state"]
    yield chunk["begins_unix_s"], dict(state)
    for change in chunk["changes"]:
        state.update(change["set"])
        for key, fields in change["patch"].items():
            state[key] = {**state[key], **fields}
        for key, parts in change["splice"].items():
            for name, (front, back, middle) in parts.items():
                old = state[key][name]
                spliced = old[:front] + middle + old[len(old) - back :]
                state[key] = {**state[key], name: spliced}
        for key in change["delete"]:
            del state[key]
        yield change["unix_s"], dict(state)


def test_the_past_is_what_the_stream_showed(line, drive, wait_until):
    seen = []
    with line.stream() as stream:
        for number, wires in enumerate(drive.wires[:40]):
            line.send(wires)
            if number % 12 == 6:
                stamp_s = wires[-1]["stamp_s"]
                stream.until(lambda s, stamp_s=stamp_s: s.state.get("robot/r1", {}).get("stamp_s") == stamp_s)
                stream.settle()  # for a second nothing changes: a tick passes
                seen.append((time.time(), json.loads(json.dumps(stream.state))))
        stream.until(lambda s: "map" in s.state)
        stream.settle()
        live = dict(stream.state)
    for unix_s, state in seen:
        past = at(line, unix_s)
        assert quick(past) == quick(state)
        assert past["robot/r1"] == state["robot/r1"]
        assert past["mission"] == state["mission"]
    assert len({state["robot/r1"]["x_m"] for _, state in seen}) == 3  # it was under way
    # what grows comes a little later, and by then the robot may count as late
    wait_until(lambda: slow(at(line, time.time())) == slow(live))
    index = line.get("/history")
    steps = [step for chunk in index["chunks"] for step in replayed(line, chunk["number"])]
    assert steps[0][0] == index["begins_unix_s"]
    for unix_s, state in steps[::3]:
        assert at(line, unix_s + 0.0005) == state


def test_each_map_of_the_past_has_its_picture(driven, wait_until):
    latest = driven.get("/map")["version"]
    wait_until(lambda: at(driven, time.time())["map"]["version"] == latest)  # maps come every five seconds
    versions = set()
    for chunk in driven.get("/history")["chunks"]:
        shown = [state["map"]["version"] for _, state in replayed(driven, chunk["number"]) if "map" in state]
        versions.update(shown)
    assert versions
    walls = []
    for version in sorted(versions):
        response = driven.call("GET", f"/history/maps/{version}.png")
        assert response.headers["content-type"] == "image/png"
        assert "immutable" in response.headers["cache-control"]
        pixels = Image.open(io.BytesIO(response.content)).tobytes()
        walls.append(pixels.count(2))
    assert walls[-1] > 0
    assert driven.call("GET", "/map.png").content == response.content


def test_what_people_do_is_in_the_past_before_they_are_answered(line):
    note = f"/annotations/{uuid4()}"
    for text in ("first", "second"):
        words = {"kind": "note", "text": text, "x_m": 1.0, "y_m": 2.0}
        assert line.call("PUT", note, words).is_success
        (value,) = [v for k, v in at(line, time.time()).items() if k.startswith("annotation/")]
        assert value["text"] == text
    assert line.call("POST", "/stop", {"robots": None}).status_code == 200
    assert at(line, time.time())["mission"]["stopped_all"]


def test_the_past_outlives_a_restart(tmp_path, make_control, drive):
    control = make_control(tmp_path)
    line = control.open("school")
    line.register(**line.words)
    for wires in drive.wires[:20]:
        line.send(wires)
    time.sleep(0.7)
    moment = time.time()
    before = at(line, moment)
    assert before["robot/r1"]["distance_m"] > 0
    control.stop()
    control.start()
    assert at(line, moment) == before
    chunks = line.get("/history")["chunks"]
    assert [chunk["number"] for chunk in chunks] == list(range(len(chunks)))
    response = line.call("GET", "/history/chunks/0")
    assert "immutable" in response.headers["cache-control"]


def test_a_chunk_is_compressed_for_those_who_can_read_it(driven):
    plain = driven.call("GET", "/history/chunks/0", headers={"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    packed = driven.call("GET", "/history/chunks/0", headers={"Accept-Encoding": "gzip"})
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.json() == plain.json()
    assert int(packed.headers["content-length"]) < len(plain.content) / 2
    assert len(gzip.compress(plain.content)) < len(plain.content) / 2


def test_what_is_not_there_is_refused_in_a_sentence(line):
    assert line.refused("GET", "/history/chunks/999") == (404, "unknown_chunk", "number")
    assert line.refused("GET", "/history/chunks/-1")[:2] == (422, "invalid")
    assert line.refused("GET", f"/history/chunks/{10**30}")[:2] == (422, "invalid")
    assert line.refused("GET", "/history/chunks/x")[:2] == (422, "invalid")
    assert line.refused("GET", "/history/state?unix_s=1") == (404, "before_the_first", "unix_s")
    for unix_s in ("nan", "inf", "-1", "1e300", "x", ""):
        assert line.refused("GET", f"/history/state?unix_s={unix_s}")[:2] == (422, "invalid"), unix_s
    assert line.refused("GET", "/history/maps/7.png") == (404, "unknown_map", "version")
    assert line.refused("GET", "/history/maps/x.png")[:2] == (422, "invalid")
    line.at = "/missions/nowhere"
    assert line.refused("GET", "/history")[:2] == (404, "unknown_mission")
