"""A mission in which a robot's log was played: tags are on the map, and a victim."""

from __future__ import annotations

import time
from typing import Any

from playwright.sync_api import APIRequestContext

from robots.sim.wire import observation_to_wire

START = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.4, "sd_m": 0.05, "sd_rad": 0.01}


def drive(request: APIRequestContext, home: str, robot_log: Any) -> dict[str, Any]:
    """Have a robot pass tags and see a victim; return the victim and a tag."""
    post = request.post
    api = f"{home}/api/v1/missions"
    origin = {"Origin": home}
    assert post(api, data={"name": "Drill", "mission_id": "drill", "tag_key": ""}, headers=origin).ok
    robot = {"robot_id": "r1", "config": {"deployment": {"spacing_m": 2.0}}, "start_pose": START}
    assert post(f"{api}/drill/robots", data=robot, headers=origin).ok
    wires = [observation_to_wire(observation) for observation in robot_log.observations]
    for k in range(0, len(wires), 100):
        body = {"observations": wires[k : k + 100]}
        assert post(f"{api}/drill/robots/r1/observations", data=body, headers=origin, timeout=90_000).ok
    for _ in range(900):
        victims = request.get(f"{api}/drill/victims").json()["victims"]
        tags = request.get(f"{api}/drill/tags").json()["tags"]
        if victims and tags:
            return {"victim": victims[0]["victim_id"], "tag": tags[0]["tag_id"]}
        time.sleep(0.1)
    raise AssertionError("the robot's log shows no victim")
