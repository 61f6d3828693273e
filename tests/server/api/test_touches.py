"""A tag with a copy: touched by somebody who cannot have come there, told to them and to the commander."""

import re
from uuid import uuid4

from tests.server.api.test_reports import said

PRECISE = {
    "odometry": {
        "distance_sd_per_sqrt_m": 0.02,
        "turn_sd_per_sqrt_m": 0.0005,
        "turn_sd_per_sqrt_rad": 0.01,
        "lateral_sd_per_sqrt_m": 0.01,
    }
}
TAGS = {0: "A0", 2: "A1", 200: "A2"}  # at 0, 4 and 400 m


def along_a_corridor():
    """A robot drives two metres in a second."""
    return [
        {
            "seq": k,
            "stamp_s": 1.0 * k,
            "odometry": {"kind": "displacement", "dx_m": 2.0 if k else 0.0, "dy_m": 0.0, "dtheta_rad": 0.0},
            "tag_sightings": [{"tag_id": TAGS[k]}] if k in TAGS else [],
        }
        for k in range(204)
    ]


def test_a_touch_that_cannot_be_alerts_the_commander_and_outlives_a_restart(make_control, tmp_path):
    control = make_control(tmp_path)
    line = control.open("copies")
    start = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
    line.register(config=PRECISE, start_pose=start)
    with line.stream() as stream:
        line.send(along_a_corridor())
        stream.until(lambda s: {"tag/A0", "tag/A1", "tag/A2"} <= s.state.keys())

    def alerts():
        return [alert for alert in line.get("/alerts")["alerts"] if alert["kind"] == "tag"]

    def touch(tag, before, after_s):
        body = said("at", tag_id=tag, from_tag=before, after_s=after_s)
        return line.call("PUT", f"/reports/{uuid4()}", body).json()["outcome"]

    for tag, before, after_s in (
        ("A2", "A0", 80.0),  # a run of 400 m
        ("A1", "A0", 0.0),  # two tags side by side
        ("A2", "nowhere", 0.0),
        ("nowhere", "A0", 0.0),
    ):
        assert touch(tag, before, after_s) == "It was noted."
    assert alerts() == []
    text = touch("A2", "A0", 1.4)
    assert re.match(
        r"operator touched tag A2 1 s after tag A0, which is 40\d m away on the map: nobody", text
    )
    assert touch("A2", "A1", 0.2).startswith("operator touched tag A2")
    (alert,) = alerts()  # once for both
    assert (alert["kind"], alert["tag_id"], alert["severity"]) == ("tag", "A2", "warning")
    assert "There are two tags A2, or one of the two was moved" in alert["text"]
    assert len(line.events("tag_twice")) == 1
    control.stop()
    control.start()
    assert alerts() == [alert]
    body = said("at", tag_id="A2", after_s=1.0)
    assert line.refused("PUT", f"/reports/{uuid4()}", body)[:2] == (422, "invalid")
    body = said("at", tag_id="A2", from_tag="A0", after_s=-1.0)
    assert line.refused("PUT", f"/reports/{uuid4()}", body)[:2] == (422, "invalid")
