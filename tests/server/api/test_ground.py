"""Layers of the ground through the API, on what a robot of the simulator really drove."""

from io import BytesIO

import numpy as np
from PIL import Image


def test_how_well_ground_was_looked_at(driven):
    found = driven.get("/coverage")
    assert found["free_m2"] > found["safe_m2"] > found["cleared_m2"] > 5.0
    answer = driven.call("GET", "/coverage.png")
    classes = np.array(Image.open(BytesIO(answer.content)))
    assert classes.shape == (found["map"]["height"], found["map"]["width"])
    cell_m2 = found["map"]["resolution_m"] ** 2
    assert abs((classes == 3).sum() * cell_m2 - found["cleared_m2"]) < 1e-6
    again = driven.call("GET", "/coverage.png", headers={"If-None-Match": answer.headers["etag"]})
    assert again.status_code == 304


def test_a_team_of_one_has_the_map_of_its_robot(driven):
    own, team = driven.get("/robots/r1/map"), driven.get("/map")
    assert abs(own["explored_m2"] - team["explored_m2"]) < 0.03 * team["explored_m2"]
    assert np.allclose(own["origin_m"], team["origin_m"], atol=0.2)
    assert driven.call("GET", "/robots/r1/map.png").headers["content-type"] == "image/png"
    assert driven.refused("GET", "/robots/r9/map")[:2] == (404, "unknown_robot")


def test_where_a_robot_was_heard_and_what_memories_tell(driven):
    (way,) = driven.get("/contact")["robots"]
    assert len(way["points_m"]) == len(way["heard"]) > 5
    memories = driven.get("/memories")
    assert {tag["cell_m"] for tag in memories["tags"]} == {1.0}
    told = [tag for tag in memories["tags"] if "#" in "".join(tag["window"])]
    assert told, "the drive writes into a tag"
    tags = {tag["tag_id"]: tag for tag in driven.get("/tags")["tags"]}
    assert all(tags[tag["tag_id"]]["x_m"] == tag["x_m"] for tag in told)


def test_before_the_first_scan_there_is_none(line):
    assert line.refused("GET", "/coverage") == (404, "no_map", None)
    assert line.refused("GET", "/robots/r1/map") == (404, "no_map", None)
    assert line.get("/memories")["tags"] == []
