"""Sectors and operational periods as a command post uses them."""

from uuid import uuid4

import pytest

from robots.exploration.area import holds
from server.mission.sectors import middle_of, signed_m2

SQUARE = [[0.0, 0.0], [8.0, 0.0], [8.0, 5.0], [0.0, 5.0]]


def test_the_story_of_a_sector(make_control, tmp_path, drive):
    control = make_control(tmp_path)
    line = control.open("school")
    line.register(**line.words)
    at = f"/sectors/{uuid4()}"
    sector = {"name": "B2", "area_m": SQUARE}
    with line.stream() as stream:
        drawn = line.call("PUT", at, sector).json()
        assert (drawn["status"], drawn["size_m2"], drawn["period"]) == ("unassigned", 40.0, None)
        assert line.call("PUT", at, sector).json() == drawn
        assert line.refused("POST", f"{at}/explore")[:2] == (409, "no_robots")
        first = line.call("POST", "/periods", {"commander": "Ada", "objectives": "North wing"}).json()
        assert (first["number"], first["ended_unix_s"]) == (1, None)
        assigned = {**sector, "status": "under_way", "robots": ["r1"], "team": "AUS01"}
        given = line.call("PUT", at, assigned).json()
        assert (given["robots"], given["team"], given["period"]) == (["r1"], "AUS01", 1)
        second = line.call("POST", "/periods", {"commander": "Ben"}).json()
        stream.until(lambda s: s.state.get("period/1", {}).get("ended_unix_s") == second["begun_unix_s"])
        searched = line.call("PUT", at, {**assigned, "status": "searched", "note": "two rooms"}).json()
        assert (searched["period"], searched["created_unix_s"]) == (2, drawn["created_unix_s"])
        stream.until(lambda s: s.state.get(f"sector/{searched['sector_id']}") == searched)
        entry = line.get("/audit?limit=1")["entries"][0]
        assert line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
        stream.until(lambda s: s.state[f"sector/{searched['sector_id']}"]["status"] == "under_way")
    assert line.call("POST", "/periods/end").json()["number"] == 2
    assert line.refused("POST", "/periods/end")[:2] == (409, "no_period")
    control.stop()
    control.start()
    line = control.line("school")
    assert line.get("/sectors")["sectors"] == [given]
    assert [period["commander"] for period in line.get("/periods")["periods"]] == ["Ada", "Ben"]
    line.send(drive.wires[0])
    (order_id,) = line.call("POST", f"{at}/explore").json()["order_ids"]
    (order,) = line.get("/robots/r1/orders")["orders"]
    assert (order["order_id"], order["kind"], order["area_m"]) == (order_id, "explore_here", SQUARE)
    line.send(drive.wires[1])
    assert line.get("/robots/r1/orders")["orders"][0]["state"] == "delivered"
    assert line.call("DELETE", at).status_code == 204
    assert line.get("/sectors") == {"sectors": []}
    assert [event["text"] for event in line.events("sector")][
        -1
    ] == "Sector B2 is searched (r1, AUS01), says operator."


def test_the_story_of_a_worksite(control):
    line = control.open("worksite")
    at = f"/sectors/{uuid4()}"
    sector = {"name": "B2", "area_m": SQUARE}
    site = {
        "worksite_id": "B-3", "hazards": "gas", "triage": "C", "is_complete": False, "visits": [],
        "ratings": [], "clearances": [],
    }  # fmt: skip
    went = {
        "team": "AUS01", "level": 3, "entered_unix_s": 1e9, "left_unix_s": None, "is_finished": False,
        "parts": "",
    }  # fmt: skip
    assert line.call("PUT", at, {**sector, "worksite": site}).json()["worksite"] == site
    inside = {**site, "visits": [went]}
    assert line.call("PUT", at, {**sector, "worksite": inside}).json()["worksite"] == inside
    assert line.call("PUT", at, {**sector, "note": "left out"}).json()["worksite"] == inside
    assert line.refused("PUT", at, {**sector, "worksite": site})[:2] == (409, "visits_lost")
    assert line.refused("PUT", at, {**sector, "worksite": {**inside, "is_complete": True}})[:2] == (
        422,
        "invalid",
    )
    out = {**went, "left_unix_s": 1e9 + 60, "is_finished": True}
    done = {**inside, "visits": [out], "is_complete": True}
    assert line.call("PUT", at, {**sector, "worksite": done}).json()["worksite"] == done
    rating = {"team": "USA02", "risk": "high", "entry": "left", "rated_unix_s": 1e9 + 70}
    cleared = {"team": "AUS01", "found": "deceased", "cleared_unix_s": 1e9 + 80}
    marked = {**done, "ratings": [rating], "clearances": [cleared]}
    assert line.call("PUT", at, {**sector, "worksite": marked}).json()["worksite"] == marked
    assert line.refused("PUT", at, {**sector, "worksite": done})[:2] == (409, "visits_lost")
    told = [event["text"].split(", says")[0] for event in line.events("sector")]
    assert told == [
        "Sector B2 is free",
        "Worksite B-3 is triaged C",
        "AUS01 went into worksite B-3",
        "AUS01 left worksite B-3, all is searched",
        "Worksite B-3 needs no more work",
        "USA02 found the structure of worksite B-3 a high risk",
        "AUS01 searched worksite B-3: only deceased are left",
    ]
    entry = line.get("/audit?limit=1")["entries"][0]
    assert line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
    assert line.get("/sectors")["sectors"][0]["worksite"] == done


@pytest.mark.parametrize(
    ("more", "code"),
    [
        ({"area_m": SQUARE[:2]}, "invalid"),
        ({"area_m": [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]}, "invalid"),
        ({"robots": ["r1"]}, "invalid"),
        ({"status": "under_way"}, "invalid"),
        ({"status": "lost"}, "invalid"),
        ({"status": "under_way", "robots": ["r9"]}, "unknown_robot"),
        ({"name": ""}, "invalid"),
        ({"worksite": {"worksite_id": "B3"}}, "invalid"),
        ({"worksite": {"worksite_id": "B-3", "triage": "E"}}, "invalid"),
        (
            {
                "worksite": {
                    "worksite_id": "B-3",
                    "ratings": [{"team": "AUS01", "risk": "unsafe", "rated_unix_s": 1}],
                }
            },
            "invalid",
        ),
        (
            {"worksite": {"worksite_id": "B-3", "visits": [{"team": "AUS01", "entered_unix_s": -1}]}},
            "invalid",
        ),
    ],
)
def test_what_is_no_sector_is_refused(line, more, code):
    refusal = line.refused("PUT", f"/sectors/{uuid4()}", {"name": "B2", "area_m": SQUARE, **more})
    assert refusal[:2] == (422, code)
    assert line.get("/sectors") == {"sectors": []}


def test_robots_are_sent_to_a_place_inside_however_a_sector_is_bent():
    for corners in (
        ((0.0, 0.0), (9.0, 0.0), (9.0, 1.0), (1.0, 1.0), (1.0, 9.0), (0.0, 9.0)),
        ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (8.0, 9.0), (8.0, 1.0), (1.0, 1.0), (1.0, 9.0), (0.0, 9.0)),
        ((0.0, 0.0), (4.0, 0.0), (2.0, 3.0)),
    ):
        for around in (corners, corners[::-1]):
            assert holds(around, *middle_of(around))
    assert signed_m2(((0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (0.0, 3.0))) == 6.0
