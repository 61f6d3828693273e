"""Where people walked there is a way, and nobody claims to know just where it runs."""

import time
from uuid import uuid4

from tests.server.api.test_reports import said
from tests.server.api.test_touches import PRECISE


def test_who_touches_one_tag_after_another_has_walked_a_way(make_control, tmp_path, wait_until):
    """Two robots drive apart, from A0 at 0 m to A1 at 4 m, and at A2 at 20 m: between them somebody walks."""
    control = make_control(tmp_path)
    line = control.open("walked")
    start = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
    line.register(config=PRECISE, start_pose=start)
    line.register("r2", config=PRECISE, start_pose=start | {"x_m": 20.0})

    def drive(robot, tags):
        wire = {"kind": "displacement", "dx_m": 2.0, "dy_m": 0.0, "dtheta_rad": 0.0}
        still = wire | {"dx_m": 0.0}
        line.send(
            [
                {
                    "seq": k,
                    "stamp_s": float(k),
                    "odometry": wire if k else still,
                    "tag_sightings": [{"tag_id": tag}] if tag else [],
                }
                for k, tag in enumerate(tags)
            ],
            robot,
        )

    drive("r1", ["A0", None, "A1"])
    drive("r2", ["A2", None])
    wait_until(lambda: {t["tag_id"] for t in line.get("/tags")["tags"]} == {"A0", "A1", "A2"})
    wait_until(lambda: line.get("/pocket")["ways"])
    assert line.refused("GET", "/routes?from=A0&to=tag:A2")[:2] == (409, "no_route")

    def touch(tag, before, after_s, **more):
        body = said("at", tag_id=tag, from_tag=before, after_s=after_s, **more)
        assert line.call("PUT", f"/reports/{uuid4()}", body).status_code == 201

    touch("A2", "A1", 0.4)  # nobody is that fast
    assert line.refused("GET", "/routes?from=A0&to=tag:A2")[:2] == (409, "no_route")
    touch("A2", "A1", 10.0)
    legs = line.get("/routes?from=A0&to=tag:A2")["legs"]
    assert [(leg["to_tag"], leg["walked"], leg["uncertain"]) for leg in legs] == [
        ("A1", False, legs[0]["uncertain"]),
        ("A2", True, True),
    ]
    assert abs(legs[1]["distance_m"] - 16.0) < 0.3
    assert legs[1]["text"].endswith("to tag A2. Somebody walked it; just where is not known.")
    touch("A1", "A2", 60.0, steps_m=21.9)
    (leg,) = line.get("/routes?from=A2&to=tag:A1")["legs"]
    assert leg["distance_m"] == 21.9
    time.sleep(1.1)  # an answer of /pocket may be a second old
    walked = [way[6] for way in line.get("/pocket")["ways"]]
    assert sorted(walked)[-1] == 2190
    control.stop()
    control.start()
    wait_until(lambda: line.get("/tags")["tags"])
    (leg,) = line.get("/routes?from=A2&to=tag:A1")["legs"]
    assert leg["distance_m"] == 21.9
    body = said("at", tag_id="A1", steps_m=3.0)
    assert line.refused("PUT", f"/reports/{uuid4()}", body)[:2] == (422, "invalid")
