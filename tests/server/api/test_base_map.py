"""A plan under the map: a picture with metres per pixel, or what an old mission came to."""

import io
from math import pi

import numpy as np
import pytest
from PIL import Image

from server.base_map import BaseMapError, MapWords, grid_of, words_of

YAML = """image: plan.pgm
resolution: 0.5
origin: [-2.0, 1.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def plan(kind="PPM"):
    """Three rows, top first: wall, floor, unknown; four columns, the last of them floor throughout."""
    rows = np.array([[0, 0, 0, 254], [254, 254, 254, 254], [205, 205, 205, 254]], np.uint8)
    file = io.BytesIO()
    Image.fromarray(rows).save(file, kind)
    return file.getvalue()


@pytest.mark.parametrize("kind", ["PPM", "PNG"])
def test_a_picture_becomes_ground_in_the_world(kind):
    grid = grid_of(plan(kind), words_of(YAML))
    assert grid.cells.tolist() == [[-1, -1, -1, 0], [0, 0, 0, 0], [100, 100, 100, 0]]
    assert (grid.origin_m, grid.resolution_m) == ((-2.0, 1.0), 0.5)


def test_a_turned_picture_stands_turned_about_its_corner():
    grid = grid_of(plan(), MapWords(0.5, (10.0, 0.0, pi / 2)))
    assert grid.cells.tolist() == [[100, 0, -1], [100, 0, -1], [100, 0, -1], [0, 0, 0]]
    assert grid.origin_m == pytest.approx((8.5, 0.0))
    opposite = grid_of(plan(), MapWords(0.5, (0.0, 0.0, pi)))
    assert opposite.cells.tolist() == grid_of(plan(), MapWords(0.5)).cells[::-1, ::-1].tolist()


def test_negated_pictures_have_light_walls():
    grid = grid_of(plan(), MapWords(0.5, negate=True))
    assert grid.cells[2].tolist() == [0, 0, 0, 100]


@pytest.mark.parametrize(
    "text",
    ["", "x", "[1, 2]", "resolution: no", "resolution: .nan", "resolution: 0", "resolution: 0.1\norigin: 7",
     "resolution: 0.1\norigin: [a, b]", "resolution: 0.1\nfree_thresh: 0.9", "a: &a [x]\nb: [*a, *a",
     "r: " + "x" * 5000],
)  # fmt: skip
def test_what_is_no_yaml_of_a_map_is_refused(text):
    with pytest.raises(BaseMapError):
        words_of(text)


def test_the_story_of_a_base_map(make_control, tmp_path, drive):
    control = make_control(tmp_path)
    line = control.open("school")
    assert line.refused("GET", "/base-map.png") == (404, "no_base_map", None)
    for body, params in (
        (b"no picture", {"resolution_m": 0.1}),
        (plan(), {}),
        (plan(), {"yaml": "x"}),
        (plan()[:9], {"yaml": YAML}),
    ):
        assert line.refused("PUT", "/base-map", content=body, params=params)[:2] == (422, "no_plan")
    with line.stream() as stream:
        laid = line.call("PUT", "/base-map", content=plan(), params={"yaml": YAML, "source": "plan.pgm"})
        assert laid.status_code == 200, laid.text
        found = laid.json()
        assert (found["width"], found["height"], found["source"]) == (4, 3, "plan.pgm")
        stream.until(lambda s: s.state.get("base_map") == found)
    png = control.call("GET", found["png"].removeprefix("/api/v1")).content
    assert np.asarray(Image.open(io.BytesIO(png))).tolist() == [[2, 2, 2, 1], [1, 1, 1, 1], [0, 0, 0, 1]]

    control.stop()
    control.start()
    line, next_one = control.line("school"), control.open("again")
    assert {**line.get("/base-map"), "version": 0, "png": ""} == {**found, "version": 0, "png": ""}
    assert next_one.refused("POST", "/base-map/copy", {"mission_id": "school"})[:2] == (409, "no_map")
    assert next_one.refused("POST", "/base-map/copy", {"mission_id": "nowhere"})[0] == 404
    line.register(**line.words)
    for wires in drive.wires[:15]:
        line.send(wires)
    with line.stream() as stream:
        stream.until(lambda s: s.state.get("map", {}).get("explored_m2", 0.0) > 5.0, 40.0)
    line.call("PUT", "/georeference", {"origin": {"lat_deg": 48.0, "lon_deg": 11.0}, "yaw_rad": 0.0})
    copied = next_one.call("POST", "/base-map/copy", {"mission_id": "school"}).json()
    assert copied["source"] == "SCHOOL"
    assert copied["explored_m2"] > 5.0
    assert next_one.get("/georeference")["lat_deg"] == 48.0
    entry = next(e for e in next_one.get("/audit")["entries"] if e["action"] == "copy_base_map")
    assert next_one.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
    assert next_one.refused("GET", "/base-map")[0] == 404  # what came with it goes with it
    assert next_one.refused("GET", "/georeference")[0] == 404
    assert line.call("DELETE", "/base-map").status_code == 204
    assert line.refused("GET", "/base-map")[0] == 404


def test_changes_of_a_base_map_are_taken_back(make_control, tmp_path):
    control = make_control(tmp_path)
    line = control.open("school")

    def last(action):
        return next(e for e in line.get("/audit")["entries"] if e["action"] == action)

    def undo(entry):
        return line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code

    def lay(source):
        line.call("PUT", "/base-map", content=plan(), params={"yaml": YAML, "source": source})
        return line.get("/base-map")

    def same(shown, kept):
        return {**shown, "version": 0, "png": ""} == {**kept, "version": 0, "png": ""}

    first = lay("first.pgm")
    laid_first = last("put_base_map")
    second = lay("second.pgm")
    laid_second = last("put_base_map")
    line.call("DELETE", "/base-map")
    removed = last("delete_base_map")
    # only the newest change, and across a restart
    assert line.refused("POST", f"/audit/{laid_second['audit_id']}/undo")[:2] == (409, "changed_since")
    control.stop()
    control.start()
    assert undo(removed) == 204
    assert same(line.get("/base-map"), second)
    assert control.call("GET", line.get("/base-map")["png"].removeprefix("/api/v1")).status_code == 200
    assert undo(laid_second) == 204
    assert same(line.get("/base-map"), first)
    assert undo(laid_first) == 204
    assert line.refused("GET", "/base-map")[0] == 404
    assert [e["text"] for e in line.events("base_map")].count(
        "operator took a change of the base map back."
    ) == 3

    lay("third.pgm")
    for k in range(9):
        lay(f"{k}.pgm")
    oldest = [e for e in line.get("/audit")["entries"] if e["action"] == "put_base_map"][8]
    assert oldest["after"]["base_map"]["source"] == "0.pgm"
    # only the last eight are kept
    for entry in [e for e in line.get("/audit")["entries"] if e["action"] == "put_base_map"][:8]:
        assert undo(entry) == 204
    assert line.get("/base-map")["source"] == "0.pgm"
    assert line.refused("POST", f"/audit/{oldest['audit_id']}/undo")[:2] == (409, "not_kept")
