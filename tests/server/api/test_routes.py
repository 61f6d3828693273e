"""Routes through the API, on what a robot of the simulator really drove."""

from math import hypot
from urllib.parse import quote

import pytest

from robots.tags.short_id import short_id


@pytest.fixture
def tags(driven):
    return {tag["tag_id"]: tag for tag in driven.get("/tags")["tags"]}


def test_a_route_leads_from_tag_to_tag_and_to_a_victim(driven, tags):
    a, b = driven.get("/tags")["links"][0]
    route = driven.get(f"/routes?from={a}&to=tag:{b}")
    assert route["legs"][-1]["to_tag"] == b
    assert (
        route["distance_m"] >= hypot(tags[a]["x_m"] - tags[b]["x_m"], tags[a]["y_m"] - tags[b]["y_m"]) - 1e-6
    )
    for leg, following in zip(route["legs"], route["legs"][1:], strict=False):
        assert leg["to_tag"] == following["from_tag"]
    for leg in route["legs"]:
        start = leg["points_m"][0]
        assert (start[0], start[1]) == pytest.approx(
            (tags[leg["from_tag"]]["x_m"], tags[leg["from_tag"]]["y_m"]), abs=0.01
        )
        assert leg["text"].endswith(".")
        assert 0.0 <= leg["bearing_deg"] < 360.0
    victim = driven.get("/victims")["victims"][0]
    there = driven.get(f"/routes?from={a}&to=victim:{victim['victim_id']}")
    assert (there["x_m"], there["y_m"]) == pytest.approx((victim["x_m"], victim["y_m"]), abs=0.01)
    assert there["last"]["text"].startswith(f"From tag {there['last']['from_tag']} go ")
    assert there["distance_m"] == pytest.approx(
        sum(leg["distance_m"] for leg in there["legs"]) + there["last"]["distance_m"]
    )
    assert driven.get(f"/routes?from={a}&to=tag:{a}")["legs"] == []


def test_what_is_not_there_is_named(driven, tags):
    a = next(iter(tags))
    assert driven.refused("GET", "/routes?from=none&to=tag:none") == (404, "unknown_tag", None)
    assert driven.refused("GET", f"/routes?from={a}&to=tag:none") == (404, "unknown_tag", None)
    assert driven.refused("GET", f"/routes?from={a}&to=victim:v99") == (404, "unknown_victim", None)
    assert driven.refused("GET", f"/routes?from={a}&to=moon") == (422, "invalid", "to")
    assert driven.refused("GET", "/routes?to=tag:x")[0] == 422


def test_a_tag_says_where_it_is_in_words(control, driven, tags):
    a, b = driven.get("/tags")["links"][0]
    found = control.call("GET", f"/where/{a}?mission=driven").json()
    assert found["mission_id"] == "driven"
    assert found["text"].startswith(f"You are at tag {a}, in a corridor. ")
    assert b in {neighbour["tag_id"] for neighbour in found["neighbours"]}
    assert {victim["victim_id"] for victim in found["victims"]}
    latest = control.call("GET", f"/where/{a}").json()  # other tests' robots drop tags of that name too
    assert latest["tag_id"] == a
    assert control.call("GET", "/where/nothing").status_code == 404
    assert control.call("GET", f"/where/{a}?mission=none").status_code == 404


def test_what_is_typed_off_a_label_leads_to_its_tag(driven, tags):
    tag_id = sorted(tags)[0]
    written = short_id(tag_id)
    for typed in (tag_id, written, written.lower().replace("-", " ")):
        assert tag_id in driven.control.call("GET", f"/where?typed={quote(typed)}").json()["tag_ids"]
    wrong = written[:-1] + ("0" if written[-1] != "0" else "1")
    assert driven.control.call("GET", f"/where?typed={wrong}").json() == {
        "tag_ids": [],
        "trouble": "mistyped",
    }
    assert driven.control.call("GET", "/where?typed=0000-V").json()["trouble"] in ("unknown", "mistyped")


def test_words_come_in_german_too(driven, tags):
    a, b = driven.get("/tags")["links"][0]
    route = driven.get(f"/routes?from={a}&to=tag:{b}&language=de")
    assert route["legs"][-1]["text"].endswith(f" bis Marke {b}.")
    victim = driven.get("/victims")["victims"][0]["victim_id"]
    last = driven.get(f"/routes?from={a}&to=victim:{victim}&language=de")["last"]
    assert last["text"].endswith(f"gehen: Dort ist Opfer {victim}.")
    where = driven.control.call("GET", f"/where/{a}?language=de&mission={driven.mission_id}").json()
    assert where["text"].startswith(f"Sie sind an Marke {a}, in einem Flur. ")
    assert driven.control.call("GET", f"/where/{a}?language=fr").status_code == 422


def test_the_way_out_and_back_to_the_base(driven, tags):
    a = max(tags, key=lambda tag: hypot(tags[tag]["x_m"], tags[tag]["y_m"]))
    assert driven.refused("GET", f"/routes?from={a}&to=exit") == (409, "no_place", "to")
    base = driven.get(f"/routes?from={a}&to=base")  # the robot started on that tag
    assert (base["legs"], base["last"]) == (driven.get(f"/routes?from={a}&to=tag:BASE")["legs"], None)
    assert base["legs"]
    far, near = "00000000-0000-4000-8000-00000000fa01", "00000000-0000-4000-8000-00000000fa02"
    order = sorted(tags, key=lambda tag: driven.get(f"/routes?from={a}&to=tag:{tag}")["distance_m"])
    driven.call("PUT", f"/annotations/{far}", {"kind": "exit", "text": "gate", "tag_id": order[-1]})
    driven.call("PUT", f"/annotations/{near}", {"kind": "exit", "text": "", "tag_id": order[1]})
    assert driven.get(f"/routes?from={a}&to=exit:{far}")["legs"][-1]["to_tag"] == order[-1]
    assert driven.get(f"/routes?from={a}&to=exit")["legs"][-1]["to_tag"] == order[1]
    assert driven.get(f"/routes?from={a}&to=exit")["last"] is None
    assert driven.refused("GET", f"/routes?from={a}&to=exit:none") == (404, "unknown_exit", None)
    for note in (far, near):
        driven.call("DELETE", f"/annotations/{note}")
