"""Tags' memories, victims, annotations and the map, as people and robots use them."""

import base64
from io import BytesIO
from uuid import uuid4

import numpy as np
import pytest
from PIL import Image

from robots.tags.memory import SIDE, TagMemory
from robots.tags.sealed import close_memory, open_memory

BYTES = {"Content-Type": "application/octet-stream"}


def memory(*cells):
    found = TagMemory(np.zeros((SIDE, SIDE), np.uint8))
    for row, column, value in cells:
        found.cells[row, column] = value
    return found


def record(*cells, tag_id="A4", key=b"", revision=0):
    return close_memory(memory(*cells), revision, tag_id, key, 500)


def known_of(line, tag_id, key=b""):
    says = open_memory(line.call("GET", f"/tags/{tag_id}/memory").content, tag_id, key)
    assert says.trusted
    return says.memory


def test_memories_merge(line):
    first, second = ((0, 0, 2), (3, 4, 1)), ((3, 4, 2), (9, 9, 1))
    assert line.refused("GET", "/tags/A4/memory") == (404, "unknown_tag", None)
    assert line.refused("GET", "/tags/A4/memory/content") == (404, "unknown_tag", None)
    merged = line.call("POST", "/tags/A4/memory", content=record(*first), headers=BYTES)
    told = line.get("/tags/A4/memory/content")
    assert (told["tag_id"], told["cell_m"]) == ("A4", 1.0)
    assert "".join(told["memory"]["window"]).count("#") == 1
    assert open_memory(merged.content, "A4", b"").memory == memory(*first)
    assert merged.headers["content-type"] == "application/octet-stream"
    merged = line.call("POST", "/tags/A4/memory", content=record(*second), headers=BYTES)
    assert open_memory(merged.content, "A4", b"").memory == memory(*first).merge(memory(*second))
    assert line.call("GET", "/tags/A4/memory").content == merged.content


@pytest.mark.parametrize(
    "garbage",
    [b"", b"x", b"\1" * 186, bytes(10_000), record((1, 1, 1), tag_id="B"), record((1, 1, 1))[:-1]],
    ids=range(6),
)
def test_garbage_is_no_memory(line, garbage):
    line.call("POST", "/tags/A4/memory", content=record((1, 1, 1)), headers=BYTES)
    assert line.refused("POST", "/tags/A4/memory", content=garbage)[:2] == (422, "invalid_memory")
    assert known_of(line, "A4") == memory((1, 1, 1))


def test_a_mission_has_a_seal_of_its_own_and_strangers_are_not_believed(control):
    line = control.open(tag_key="00ff17")
    ours, forged = record((1, 1, 1), key=bytes.fromhex("00ff17")), record((2, 2, 2), key=b"", revision=9)
    assert line.refused("POST", "/tags/A4/memory", content=forged)[:2] == (422, "invalid_memory")
    line.call("POST", "/tags/A4/memory", content=forged + ours, headers=BYTES)
    assert known_of(line, "A4", bytes.fromhex("00ff17")) == memory((1, 1, 1))
    other = control.open(tag_key=None)  # its key is made at random and never told
    assert "tag_key" not in other.get("")
    assert other.refused("POST", "/tags/A4/memory", content=ours)[:2] == (422, "invalid_memory")


def test_a_key_that_is_none_is_refused(control):
    for key in ("0", "xy", "AB", "00" * 33):
        assert control.call("POST", "/missions", {"name": "M", "tag_key": key}).status_code == 422


def test_a_tag_has_a_name_that_can_be_one(line):
    assert line.refused("POST", f"/tags/{'x' * 65}/memory", content=record()) == (422, "invalid", "tag_id")


def test_what_a_robot_reads_is_merged_and_what_does_not_count_is_told_once(line):
    forged = record((1, 1, 2), key=b"stranger")
    for seq, data in enumerate([record((5, 5, 2)), b"garbage", b"garbage", b"garbage", forged, forged]):
        sighting = {"tag_id": "A4", "memory": base64.b64encode(data).decode()}
        line.send([{"seq": seq, "stamp_s": 1.0 * seq, "tag_sightings": [sighting]}])
    assert known_of(line, "A4") == memory((5, 5, 2))
    garbage, strange = line.events("tag_unreadable")
    assert (garbage["robot_id"], garbage["severity"]) == ("r1", "warning")
    assert "another seal" in strange["text"]


def test_what_an_agent_writes_is_merged(driven, drive):
    writes = [write for batch in drive.updates for update in batch for write in update.command.writes]
    assert writes
    for write in writes:
        known = known_of(driven, write.tag_id)
        assert known.merge(open_memory(write.memory, write.tag_id, b"").memory) == known


def test_tags_have_places(driven):
    tag = driven.get("/tags")["tags"][0]
    assert driven.get(f"/tags/{tag['tag_id']}") == tag
    assert tag["robots"] == ["r1"]
    assert driven.refused("GET", "/tags/nowhere") == (404, "unknown_tag", None)


def test_a_victim_is_seen_and_judged(line, drive):
    for wires in drive.wires[:45]:
        line.send(wires)
    with line.stream() as stream:
        stream.until(lambda s: "victim_seen" in {event["kind"] for event in s.kind("event")})
        victim = stream.kind("victim")[0]
        at = f"/victims/{victim['victim_id']}"
        (event,) = line.events("victim_seen")[:1]
        assert event["severity"] == "alarm"
        assert victim["victim_id"] in event["text"]
        assert (victim["status"], victim["by"]) == ("suspected", "")
        judged = line.call("PATCH", at, {"status": "reached", "note": "awake"}).json()
        assert (judged["status"], judged["note"], judged["by"]) == ("reached", "awake", "operator")
        stream.until(lambda s: s.state[f"victim/{victim['victim_id']}"]["status"] == "reached")
        for wires in drive.wires[45:]:  # robots measure on, and change nothing of what was said
            line.send(wires)
        key = f"victim/{victim['victim_id']}"  # the team's map comes when it has been solved
        stream.until(lambda s: s.state[key]["sightings"] > victim["sightings"], seconds=60.0)
    later = line.get(at)
    assert later["sightings"] > victim["sightings"]
    assert (later["status"], later["note"], later["by"]) == ("reached", "awake", "operator")
    assert line.call("PATCH", at, {"status": "extricated"}).json()["note"] == "awake"
    assert line.refused("PATCH", at, {"status": "fine"}) == (422, "invalid", "status")
    assert line.refused("PATCH", "/victims/v9", {"status": "reached"}) == (
        404,
        "unknown_victim",
        None,
    )
    assert [event["kind"] for event in line.events("victim_judged")] == ["victim_judged"] * 2


def test_annotations_are_written_once_however_often_they_are_sent(line):
    at = f"/annotations/{uuid4()}"
    body = {"kind": "hazard", "text": "gas", "x_m": 3.0, "y_m": -1.5}
    with line.stream() as stream:
        first = line.call("PUT", at, body)
        assert first.status_code == 200
        stream.until(lambda s: s.kind("annotation") == [first.json()])
        assert line.call("PUT", at, body).json() == first.json()
        assert line.get("/annotations")["annotations"] == [first.json()]
        changed = line.call("PUT", at, {**body, "text": "much gas"}).json()
        assert changed["created_unix_s"] == first.json()["created_unix_s"]
        stream.until(lambda s: s.kind("annotation") == [changed])
        assert line.call("DELETE", at).status_code == 204
        stream.until(lambda s: not s.kind("annotation"))
    assert line.refused("DELETE", at) == (404, "unknown_annotation", None)
    assert line.get("/annotations")["annotations"] == []


def test_an_area_is_drawn_taken_back_and_kept(tmp_path, make_control):
    line = make_control(tmp_path).open("mine")
    at = f"/annotations/{uuid4()}"
    area = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.5]]
    drawn = line.call("PUT", at, {"kind": "searched", "text": "", "area_m": area}).json()
    assert drawn["area_m"] == area
    line.call("DELETE", at)
    entry = line.get("/audit")["entries"][0]
    assert line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
    line.control.stop()
    line.control.start()
    assert line.get("/annotations")["annotations"] == [drawn]


@pytest.mark.parametrize(
    "place",
    [
        {},
        {"x_m": 1.0},
        {"tag_id": "A", "x_m": 1.0, "y_m": 1.0},
        {"tag_id": "A", "x_m": 1.0},
        {"tag_id": "A", "area_m": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]},
        {"area_m": [[0.0, 0.0], [1.0, 0.0]]},
    ],
    ids=["none", "half", "both", "tag and half", "area and tag", "a line is no area"],
)
def test_an_annotation_has_one_place(line, place):
    body = {"kind": "note", "text": "x", **place}
    assert line.refused("PUT", f"/annotations/{uuid4()}", body)[0] == 422
    assert line.refused("PUT", "/annotations/7", {**body, "tag_id": "A"})[::2] == (422, "annotation_id")


def test_text_that_is_no_text_is_refused(line):
    body = '{"kind": "note", "text": "\\ud800", "tag_id": "A"}'
    response = line.call(
        "PUT", f"/annotations/{uuid4()}", content=body, headers={"Content-Type": "application/json"}
    )
    assert (response.status_code, response.json()["error"]["field"]) == (422, "text")


def test_the_map_is_sent_once(driven):
    map_ = driven.get("/map")
    first = driven.control.call("GET", map_["png"].removeprefix("/api/v1"))
    assert first.headers["content-type"] == "image/png"
    etag = first.headers["etag"]
    for match in (etag, f'"other", {etag}'):
        again = driven.call("GET", "/map.png", headers={"If-None-Match": match})
        assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", etag)
    assert driven.call("GET", "/map.png", headers={"If-None-Match": '"other"'}).status_code == 200
    picture = np.asarray(Image.open(BytesIO(first.content)))
    assert picture.shape == (map_["height"], map_["width"])
    assert set(np.unique(picture)) == {0, 1, 2}


def test_the_picture_and_the_trail_fit(driven):
    """Row 0 is the top: nearly every point that the robot drove over is free."""
    map_ = driven.get("/map")
    picture = np.asarray(Image.open(BytesIO(driven.call("GET", "/map.png").content)))
    with driven.stream() as stream:
        trail = np.array(stream.state["trail/r1"]["points_m"])
    columns = ((trail[:, 0] - map_["origin_m"][0]) / map_["resolution_m"]).astype(int)
    rows = map_["height"] - 1 - ((trail[:, 1] - map_["origin_m"][1]) / map_["resolution_m"]).astype(int)
    assert len(trail) > 10
    assert (picture[rows, columns] == 1).mean() > 0.95


def test_without_scans_there_is_no_map(line):
    assert line.refused("GET", "/map") == (404, "no_map", None)
    assert line.refused("GET", "/map.png") == (404, "no_map", None)


@pytest.fixture
def two(control, drive, wait_until):
    """A mission with two victims at least; their ids."""
    line = control.open()
    line.register(**line.words)
    for wires in drive.wires:
        line.send(wires)
    wait_until(lambda: len(line.get("/victims")["victims"]) > 1)
    return line, [victim["victim_id"] for victim in line.get("/victims")["victims"]][:2]


def test_what_people_find_out_about_a_victim_is_kept_piece_by_piece(two):
    line, (first, _) = two
    at = f"/victims/{first}"
    measured = line.get(at)
    assert (measured["triage"], measured["live"], measured["by"]) == ("unknown", None, "")
    line.call("PATCH", at, {"status": "confirmed", "live": 1, "dead": 0})
    line.call("PATCH", at, {"team": "AUS01"})
    line.call("PATCH", at, {"start": {"walks": False, "breaths_per_min": 34}})
    found = line.get(at)
    assert (found["status"], found["live"], found["team"]) == ("confirmed", 1, "AUS01")
    assert (found["triage"], found["start"]["pulse"]) == ("immediate", None)
    line.call("PATCH", at, {"place_m": {"x_m": 9.0, "y_m": 8.0}})
    assert (line.get(at)["x_m"], line.get(at)["y_m"]) == (9.0, 8.0)
    line.call("PATCH", at, {"place_m": None})
    assert line.get(at)["x_m"] == pytest.approx(measured["x_m"], abs=0.5)
    texts = [event["text"] for event in line.events("victim_judged")]
    assert texts[0] == f"Victim {first} is confirmed, has 1 live and 0 dead, says operator."
    assert texts[2] == f"Victim {first} is triaged immediate, says operator."
    for body in (
        {},
        {"status": None},
        {"live": -1},
        {"start": {"breaths_per_min": 500}},
        {"place_m": {"x_m": 1.0}},
        {"triage": "deceased"},
    ):
        assert line.refused("PATCH", at, body)[:2] == (422, "invalid"), body


def test_victims_that_are_one_are_merged_and_split_again(two):
    line, (first, second) = two
    assert line.call("PATCH", f"/victims/{second}", {"merged_into": first}).status_code == 200
    assert line.refused("PATCH", f"/victims/{first}", {"merged_into": second})[:2] == (409, "cannot_merge")
    assert line.refused("PATCH", f"/victims/{first}", {"merged_into": first})[:2] == (409, "cannot_merge")
    assert line.refused("PATCH", f"/victims/{first}", {"merged_into": "v99"})[:2] == (409, "cannot_merge")
    entry = line.get("/audit")["entries"][0]
    assert line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
    assert line.get(f"/victims/{second}")["merged_into"] is None
    assert line.call("PATCH", f"/victims/{second}", {"merged_into": first}).status_code == 200
    assert line.call("PATCH", f"/victims/{second}", {"merged_into": None}).status_code == 200
    (*_, last) = line.events("victim_judged")
    assert last["text"] == f"Victim {second} stands for itself, says operator."
