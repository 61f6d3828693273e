"""MAYDAY, EVACUATE and alerts of robots and victims through the API, and over a restart."""

import time
from uuid import uuid4

import pytest


def test_mayday_is_heard_by_all_until_it_is_over(line):
    with line.stream() as stream:
        called = line.call("POST", "/alerts/mayday", {"text": "low on air", "tag_id": "A4"})
        assert called.status_code == 201
        assert called.json()["text"] == "MAYDAY from operator near tag A4: low on air."
        assert line.call("POST", "/alerts/mayday", {}).json() == called.json()  # pressed again
        stream.until(lambda s: s.state.get("alert/mayday:operator", {}).get("severity") == "alarm")
        line.call("POST", "/alerts/mayday:operator/acknowledge")
        assert len(line.get("/alerts")["alerts"]) == 1  # noted, but it goes on
        assert line.call("DELETE", "/alerts/mayday/operator").status_code == 204
        stream.until(lambda s: "alert/mayday:operator" not in s.state)
    assert line.refused("DELETE", "/alerts/mayday/operator") == (404, "unknown_mayday", None)
    assert [len(line.events(kind)) for kind in ("mayday", "mayday_over")] == [1, 1]
    assert line.refused("POST", "/alerts/mayday", {"text": "x" * 501}) == (422, "invalid", "text")


def test_whoever_calls_mayday_again_is_told_of_anew(line):
    def call(**more):
        words = {"kind": "mayday", "phone_unix_s": time.time(), "sent_phone_unix_s": time.time(), **more}
        assert line.call("PUT", f"/reports/{uuid4()}", words).status_code == 201
        (alert,) = line.get("/alerts")["alerts"]
        return alert

    first = call(tag_id="T1")
    line.call("POST", f"/alerts/{first['alert_id']}/acknowledge")
    again = call(tag_id="T2", text="trapped")  # before anybody has said that it is over
    assert again["text"] == "MAYDAY from operator near tag T2, before that near tag T1: trapped."
    assert (again["tag_id"], again["acknowledged_unix_s"]) == ("T2", None)  # consoles sound once more
    assert again["raised_unix_s"] > first["raised_unix_s"]
    other = call()  # a second one, not noted yet: the place that is known stays
    assert (other["text"], other["tag_id"]) == ("MAYDAY from operator, before that near tag T2.", "T2")
    assert len(line.events("mayday")) == 3
    line.call("POST", f"/alerts/{other['alert_id']}/acknowledge")
    assert line.call("POST", "/alerts/mayday", {}).status_code == 201
    assert line.call("POST", "/alerts/mayday", {}).status_code == 200  # nothing new, and still not noted
    assert line.call("POST", "/alerts/mayday", {"tag_id": "T3"}).json()["tag_id"] == "T3"
    assert len(line.events("mayday")) == 5


def test_mayday_is_taken_in_a_mission_that_is_over(control):
    line = control.open()
    line.call("POST", "/evacuation")
    since = line.get("/evacuation")["since_unix_s"]
    at = {"kind": "at", "tag_id": "T1", "phone_unix_s": 5.0, "sent_phone_unix_s": 6.0}
    path = f"/reports/{uuid4()}"
    assert line.call("PUT", path, at).status_code == 201
    assert line.call("POST", "/close").status_code == 200
    clocks = {"phone_unix_s": 5.0, "sent_phone_unix_s": 6.0}
    for words in ({"kind": "mayday", "tag_id": "T1"}, {"kind": "heard", "since_unix_s": since}):
        assert line.call("PUT", f"/reports/{uuid4()}", words | clocks).status_code == 201
    assert [alert["kind"] for alert in line.get("/alerts")["alerts"]] == ["mayday"]
    assert [heard["name"] for heard in line.get("/evacuation")["acknowledged"]] == ["operator"]
    assert line.call("PUT", path, at).status_code == 200  # its answer was lost before
    assert line.refused("PUT", f"/reports/{uuid4()}", at) == (409, "mission_closed", None)


@pytest.mark.parametrize("tag_id", ["T 1", "", "x" * 500, 7])
def test_mayday_is_not_refused_for_what_it_names_as_its_tag(line, tag_id):
    clocks = {"phone_unix_s": 5.0, "sent_phone_unix_s": 6.0}
    path = f"/reports/{uuid4()}"
    assert line.call("PUT", path, {"kind": "mayday", "tag_id": tag_id, **clocks}).status_code == 201
    (alert,) = line.get("/alerts")["alerts"]
    assert alert["tag_id"] is None
    assert alert["text"].startswith("MAYDAY from operator: the tag there reads")
    assert str(tag_id)[:60] in alert["text"]
    assert line.call("POST", "/alerts/mayday", {"tag_id": tag_id}).status_code == 200


def test_evacuate_holds_over_a_restart_and_is_acknowledged_by_name(tmp_path, make_control):
    line = make_control(tmp_path).open("mine")
    assert line.refused("POST", "/evacuation/acknowledge") == (409, "not_ordered", None)
    with line.stream() as stream:
        line.call("POST", "/evacuation")
        stream.until(lambda s: s.state.get("evacuation", {}).get("ordered"))
    since = line.get("/evacuation")["since_unix_s"]
    line.control.stop()
    line.control.start()
    line.call("POST", "/evacuation")  # ordered again: it is the same order
    assert line.get("/evacuation")["since_unix_s"] == since
    for _ in range(2):
        answer = line.call("POST", "/evacuation/acknowledge").json()
    assert [heard["name"] for heard in answer["acknowledged"]] == ["operator"]
    with line.stream() as stream:
        assert stream.state["evacuation"]["acknowledged"] == answer["acknowledged"]
        assert line.call("DELETE", "/evacuation").json()["ordered"] is False
        stream.until(lambda s: "evacuation" not in s.state)
    assert [len(line.events(kind)) for kind in ("evacuate", "evacuate_heard", "evacuate_over")] == [1, 1, 1]


def test_evacuate_holds_where_the_disk_is_full(control):
    line = control.open()
    with control.failing("evacuations"):
        assert line.refused("POST", "/evacuation")[0] == 503
    assert line.get("/evacuation")["ordered"]


def test_a_victim_is_an_alert_until_a_person_has_judged_it(control, drive, wait_until):
    line = control.open()
    line.register(**line.words)
    for wires in drive.wires[:60]:
        line.send(wires)
    wait_until(lambda: [a for a in line.get("/alerts")["alerts"] if a["kind"] == "victim"])
    (alert,) = [a for a in line.get("/alerts")["alerts"] if a["kind"] == "victim"][:1]
    assert alert["severity"] == "alarm"
    line.call("PATCH", f"/victims/{alert['victim_id']}", {"status": "confirmed"})
    assert alert["alert_id"] not in {a["alert_id"] for a in line.get("/alerts")["alerts"]}


@pytest.mark.parametrize("kind", ["order_evacuation", "call_mayday"])
def test_both_are_in_the_audit_log(line, kind):
    line.call("POST", "/evacuation")
    line.call("POST", "/alerts/mayday", {})
    assert kind in {entry["action"] for entry in line.get("/audit")["entries"]}
