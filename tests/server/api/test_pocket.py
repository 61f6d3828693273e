"""A mission in one file: what the interface tells piece by piece, sent again only when it has changed."""

import base64
import io
import json
import time

import numpy as np
from PIL import Image

from server.schemas.pocket import PocketOut


def pocket_of(line, have="", **headers):
    return line.control.call("GET", f"/missions/{line.mission_id}/pocket?have={have}", headers=headers)


def test_a_phone_carries_what_the_interface_tells(driven):
    found = pocket_of(driven)
    assert found.headers["content-encoding"] == "gzip"
    pocket = PocketOut.model_validate(json.loads(found.content), strict=False)
    tags = driven.get("/tags")
    assert {t.tag_id for t in pocket.tags} == {t["tag_id"] for t in tags["tags"]}
    names = [t.tag_id for t in pocket.tags]
    assert pocket.ways
    for a, b, cm, points, *_ in pocket.ways:
        (leg,) = driven.get(f"/routes?from={names[a]}&to=tag:{names[b]}")["legs"][:1]
        assert len(points) >= 4
        if leg["to_tag"] == names[b]:
            assert (np.array(points).reshape(-1, 2) / 100).tolist() == leg["points_m"]
            assert cm == round(100 * leg["distance_m"])
    of = driven.mission_id  # other missions have tags of these names
    where = {name: driven.control.call("GET", f"/where/{name}?mission={of}").json() for name in names}
    assert {t.tag_id: t.place_kind for t in pocket.tags} == {n: w["place_kind"] for n, w in where.items()}
    assert any(" in a corridor. " in each["text"] for each in where.values())  # where it drove
    victims = driven.get("/victims")["victims"]
    assert [v.victim_id for v in pocket.victims] == [v["victim_id"] for v in victims]
    ends = dict(pocket.victims[0].ends)
    last = driven.get(f"/routes?from={names[0]}&to=victim:{victims[0]['victim_id']}")["last"]
    assert ends[last["from_tag"]] == round(100 * last["distance_m"])
    plan = Image.open(io.BytesIO(base64.b64decode(pocket.map.png)))
    assert plan.size == (pocket.map.width, pocket.map.height)
    assert pocket.left_out == {"tags": 0, "victims": 0, "notes": 0}


def test_it_is_sent_again_only_when_it_has_changed(driven):
    first = pocket_of(driven)
    etag = first.headers["etag"]
    again = pocket_of(driven, **{"If-None-Match": f'"other", {etag}'})
    assert (again.status_code, again.content) == (304, b"")
    plain = pocket_of(driven, **{"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert plain.json() == first.json()
    path = "/annotations/00000000-0000-4000-8000-00000000feed"
    driven.call("PUT", path, {"kind": "hazard", "text": "gas", "x_m": 1.0, "y_m": 0.5})
    time.sleep(1.1)  # an answer may be a second old
    changed = pocket_of(driven, **{"If-None-Match": etag})
    assert changed.status_code == 200
    assert [note["text"] for note in changed.json()["notes"]] == ["gas"]
    _what_is_there_is_left_out(driven, first.json(), changed)
    driven.call("DELETE", path)


def _what_is_there_is_left_out(driven, before, changed):
    parts, whole = before["parts"], changed.json()
    assert whole["parts"] == parts  # a note moves neither tags nor plan
    large = ("tags", "ways", "map")
    for have, missing in (
        (f"{parts['plan']},{parts['ground']}", large),
        (f"older,{parts['plan']}", ("map",)),
        (parts["ground"], ("tags", "ways")),
        ("older", ()),
    ):
        for coding in ("gzip", "identity"):
            told = pocket_of(driven, have, **{"Accept-Encoding": coding})
            assert told.headers["etag"] == changed.headers["etag"]
            assert told.json() == {key: value for key, value in whole.items() if key not in missing}
            # what is left out is what a phone has
            assert {key: before[key] for key in missing} | told.json() == whole


def test_an_empty_mission_has_one_too(control):
    pocket = PocketOut.model_validate(pocket_of(control.open()).json(), strict=False)
    assert (pocket.map, pocket.tags, pocket.ways, pocket.victims) == (None, [], [], [])


def test_a_phone_learns_from_the_next_one_that_its_note_was_taken_off(driven):
    """By the server's clock alone: what is in none that is later than the note has been taken off again."""

    def after(as_of_s):
        while True:
            found = pocket_of(driven)
            if float(found.headers["waymark-as-of"]) > as_of_s:
                return {note["annotation_id"] for note in found.json()["notes"]}
            time.sleep(0.05)

    note_id = "00000000-0000-4000-8000-0000000000aa"
    now = time.time()
    said = {"kind": "note", "note": "note", "text": "gas", "tag_id": driven.get("/tags")["tags"][0]["tag_id"]}
    said |= {"phone_unix_s": now, "sent_phone_unix_s": now}
    taken = driven.call("PUT", f"/reports/{note_id}", said)
    assert note_id in after(float(taken.headers["waymark-as-of"]))
    driven.call("DELETE", f"/annotations/{note_id}")
    etag = pocket_of(driven).headers["etag"]
    assert note_id not in after(time.time())
    same = pocket_of(driven, **{"If-None-Match": etag})
    assert float(same.headers["waymark-as-of"]) > now  # said also of what the phone has
