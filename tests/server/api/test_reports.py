"""Reports from the field: each once, at the time it was made, under the name it was made under."""

import threading
import time
from uuid import uuid4

import pytest

NOW = 1_790_000_000.0


def said(kind, phone_s=None, offset_s=None, sent_s=None, **more):
    phone_s = time.time() if phone_s is None else phone_s
    sent_s = phone_s if sent_s is None else sent_s
    clocks = {"phone_unix_s": phone_s, "offset_s": offset_s, "sent_phone_unix_s": sent_s}
    return {"kind": kind, "made_by": "operator", **clocks, **more}


def test_a_report_counts_once_however_often_it_comes(line):
    path, body = f"/reports/{uuid4()}", said("note", note="hazard", text="gas", tag_id="T0")
    answers = []
    threads = [
        threading.Thread(target=lambda: answers.append(line.call("PUT", path, body))) for _ in range(6)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(answer.status_code for answer in answers) == [200] * 5 + [201]
    (note,) = line.get("/annotations")["annotations"]
    assert (note["text"], note["tag_id"], note["by"]) == ("gas", "T0", "operator")
    assert note["annotation_id"] == path.rsplit("/", 1)[1]
    line.call("DELETE", f"/annotations/{note['annotation_id']}")
    assert line.call("PUT", path, body).status_code == 200  # late, by another way
    assert line.get("/annotations")["annotations"] == []  # what was taken off the map stays off
    assert len(line.get("/reports")["reports"]) == 1
    assert len(line.events("mayday")) == 0


def test_a_mayday_that_comes_late_says_so_and_does_not_come_back(line):
    path = f"/reports/{uuid4()}"
    body = said("mayday", phone_s=NOW, sent_s=NOW + 600, tag_id="T1", text="low on air")
    assert line.call("PUT", path, body).status_code == 201
    (alert,) = line.get("/alerts")["alerts"]
    assert alert["text"] == "MAYDAY from operator near tag T1, called 10 min ago without signal: low on air."
    assert line.call("DELETE", "/alerts/mayday/operator").status_code == 204
    line.call("POST", f"/alerts/{alert['alert_id']}/acknowledge")
    assert line.call("PUT", path, body).status_code == 200
    assert line.get("/alerts")["alerts"] == []


@pytest.mark.parametrize(
    ("phone_s", "offset_s", "sent_s", "ago_s"),
    [
        (NOW, None, NOW + 30.0, 30.0),  # it never knew: by how far its clock has gone on since
        (NOW, "right", NOW + 5e6, 90.0),  # it knew, and was set meanwhile
        (NOW, 1e9, NOW, 0.0),  # from the future: it was made no later than it came
    ],
)
def test_a_clock_that_is_wrong_by_days_does_not_matter(line, phone_s, offset_s, sent_s, ago_s):
    now = time.time()
    offset_s = now - NOW - ago_s if offset_s == "right" else offset_s
    body = said("at", phone_s=phone_s, offset_s=offset_s, sent_s=sent_s, tag_id="T0")
    found = line.call("PUT", f"/reports/{uuid4()}", body).json()
    assert found["made_unix_s"] == pytest.approx(now - ago_s, abs=5.0)
    assert (found["phone_unix_s"], found["offset_s"]) == (phone_s, offset_s)


def test_a_victim_stands_at_its_tag_and_where_that_is_unknown_a_note_does(driven):
    tag = driven.get("/tags")["tags"][0]
    start = {"walks": False, "breaths_per_min": 36}
    report = uuid4()
    body = said("victim", tag_id=tag["tag_id"], live=2, dead=1, text="under the stairs", start=start)
    for _ in range(2):
        assert (
            driven.call("PUT", f"/reports/{report}", body).json()["outcome"]
            == f"It is victim p-{str(report)[:8]}."
        )
    victim = driven.get(f"/victims/p-{str(report)[:8]}")
    assert (victim["live"], victim["dead"], victim["triage"], victim["by"]) == (2, 1, "immediate", "operator")
    assert (victim["x_m"], victim["y_m"]) == pytest.approx((tag["x_m"], tag["y_m"]), abs=1e-3)
    assert "under the stairs" in victim["note"]
    lost = driven.call("PUT", f"/reports/{uuid4()}", body | {"tag_id": "T-unknown"}).json()
    note = next(
        n for n in driven.get("/annotations")["annotations"] if n["annotation_id"] == lost["report_id"]
    )
    assert (note["kind"], note["tag_id"]) == ("victim", "T-unknown")
    assert note["text"] == "2 live, 1 dead, START: immediate. under the stairs"
    driven.call("DELETE", f"/annotations/{lost['report_id']}")
    driven.call("PATCH", f"/victims/{victim['victim_id']}", {"status": "dismissed"})


def test_evacuate_is_heard_once_for_each_order(line):
    line.call("POST", "/evacuation")
    since = line.get("/evacuation")["since_unix_s"]
    late = said("heard", since_unix_s=since - 100.0)
    assert line.call("PUT", f"/reports/{uuid4()}", late).json()["outcome"] == "That order is over."
    assert line.get("/evacuation")["acknowledged"] == []
    heard = said("heard", since_unix_s=since) | {"made_by": "ann"}
    assert line.call("PUT", f"/reports/{uuid4()}", heard).json()["outcome"] == "It was noted."
    assert [h["name"] for h in line.get("/evacuation")["acknowledged"]] == ["ann (sent by operator)"]


def test_what_was_carried_by_another_phone_is_nobody_s_own_word(line):
    """Whoever scans a code must not sign what it says, whatever name it bears."""
    signed = {}
    for made_by in ("ann", "operator", ""):
        body = said("note", note="hazard", text="gas", tag_id="T0") | {"made_by": made_by, "is_carried": True}
        signed[made_by] = line.call("PUT", f"/reports/{uuid4()}", body).json()["by"]
    assert signed == {
        "ann": "ann (carried by operator)",
        "operator": "operator (carried by operator)",
        "": "somebody (carried by operator)",
    }


def test_what_does_not_fit_is_refused_in_words(line):
    def put(body, path=None):
        return line.refused("PUT", path or f"/reports/{uuid4()}", body)

    assert put(said("note", note="hazard")) == (422, "invalid", None)
    assert put(said("at", tag_id="T0", live=1)) == (422, "invalid", None)
    assert put(said("at", tag_id="<b>"))[:2] == (422, "invalid")
    assert put(said("moon"))[2] == "kind"
    assert put(said("at", tag_id="T0"), "/reports/first")[2] == "report_id"
    assert line.get("/reports")["reports"] == []


def test_where_people_are_is_shown_and_survives_a_restart(make_control, tmp_path):
    control = make_control(tmp_path)
    line = control.open("field")
    for age_s, tag in ((10.0, "T2"), (60.0, "T1")):  # out of order
        line.call("PUT", f"/reports/{uuid4()}", said("at", phone_s=NOW, sent_s=NOW + age_s, tag_id=tag))
    with line.stream() as stream:
        assert [place["tag_id"] for place in stream.kind("responder")] == ["T2"]
    control.stop()
    control.start()
    with line.stream() as stream:
        (place,) = stream.kind("responder")
        assert (place["name"], place["tag_id"]) == ("operator", "T2")


def test_a_reported_victim_moves_with_its_tag_when_the_map_does(line):
    """The robot comes back to its first tag by a way that its odometry has too short: all between moves."""

    def drive(seq, dx_m, *tags):
        odometry = {"kind": "displacement", "dx_m": dx_m, "dy_m": 0.0, "dtheta_rad": 0.0}
        sightings = [{"tag_id": tag} for tag in tags]
        return {"seq": seq, "stamp_s": 0.5 * seq, "odometry": odometry, "tag_sightings": sightings}

    with line.stream() as stream:
        line.send([drive(k, 0.25, *{0: ["A0"], 8: ["A1"]}.get(k, [])) for k in range(16)])
        stream.until(lambda s: "tag/A1" in s.state)
        before = stream.state["tag/A1"]
        report = uuid4()
        assert line.call("PUT", f"/reports/{report}", said("victim", tag_id="A1", live=1)).status_code == 201
        key = f"victim/p-{str(report)[:8]}"
        stream.until(lambda s: key in s.state)
        line.send([drive(16 + k, -0.25, *(["A0"] if k == 12 else [])) for k in range(14)])

        def has_moved(s):
            tag = s.state["tag/A1"]
            return abs(tag["x_m"] - before["x_m"]) > 0.02 and abs(s.state[key]["x_m"] - tag["x_m"]) < 0.011

        stream.until(has_moved)
        assert stream.state[key]["tag_id"] == "A1"
    tag = {each["tag_id"]: each for each in line.get("/tags")["tags"]}["A1"]
    victim = line.get(f"/victims/p-{str(report)[:8]}")
    assert (victim["x_m"], victim["y_m"]) == pytest.approx((tag["x_m"], tag["y_m"]), abs=0.011)
    line.call("PATCH", f"/victims/{victim['victim_id']}", {"place_m": {"x_m": 9.0, "y_m": 9.0}})
    line.send([drive(30 + k, 0.25) for k in range(4)])
    assert line.get(f"/victims/{victim['victim_id']}")["x_m"] == 9.0  # a person put it there
