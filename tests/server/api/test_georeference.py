"""A mission gets its place on the Earth, loses it, and gets it back."""

from math import hypot

import pytest

from server.geo.mgrs import to_mgrs
from server.geo.utm import to_utm

ORIGIN = {"origin": {"lat_deg": 48.137154, "lon_deg": 11.576124}, "yaw_rad": 1.5708}


def test_the_story_of_a_georeference(make_control, tmp_path):
    control = make_control(tmp_path)
    line = control.open("school")
    assert line.refused("GET", "/georeference") == (404, "no_georeference", None)
    assert line.refused("GET", "/georeference/place?x_m=1&y_m=1") == (404, "no_georeference", None)
    with line.stream() as stream:
        placed = line.call("PUT", "/georeference", ORIGIN).json()
        assert (placed["lat_deg"], placed["sd_m"], placed["by"]) == (48.137154, 0.0, "operator")
        stream.until(lambda s: s.state.get("georeference") == placed)
        place = line.get("/georeference/place?x_m=0&y_m=0")
        assert place["grid"] == to_mgrs(48.137154, 11.576124)
        assert place["utm"] == str(to_utm(48.137154, 11.576124))
        points = [
            {"x_m": x, "y_m": y, "grid": line.get(f"/georeference/place?x_m={x}&y_m={y}")["grid"]}
            for x, y in ((0.0, 0.0), (60.0, 0.0), (0.0, 45.0))
        ]
        solved = line.call("PUT", "/georeference", {"control_points": points}).json()
        assert 0.0 < solved["sd_m"] < 1.0  # grid references are of whole metres
        assert len(solved["points"]) == 3
        assert abs(solved["yaw_rad"] - placed["yaw_rad"]) < 0.02
        entry = line.get("/audit?limit=1")["entries"][0]
        assert line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
        stream.until(lambda s: s.state.get("georeference") == placed)
        assert line.refused("POST", f"/audit/{entry['audit_id']}/undo")[:2] == (409, "changed_since")
    control.stop()
    control.start()
    line = control.line("school")
    assert line.get("/georeference") == placed
    assert line.call("DELETE", "/georeference").status_code == 204
    assert line.refused("DELETE", "/georeference")[0] == 404


@pytest.mark.parametrize(
    ("body", "refusal"),
    [
        ({}, (422, "invalid", None)),
        ({"origin": {"lat_deg": 48.0}, "yaw_rad": 0.0}, (422, "invalid", "origin")),
        ({"origin": {"lat_deg": 91.0, "lon_deg": 0.0}, "yaw_rad": 0.0}, (422, "invalid", "origin.lat_deg")),
        ({"origin": {"grid": "here"}, "yaw_rad": 0.0}, (422, "no_grid_reference", "origin.grid")),
        (
            {"control_points": [{"x_m": 0.0, "y_m": 0.0, "grid": "32UPU9160734903"}]},
            (422, "bad_geometry", "control_points"),
        ),
        (
            {
                "control_points": [
                    {"x_m": 0.0, "y_m": 0.0, "grid": "32UPU9160734903"},
                    {"x_m": 9.0, "y_m": 0.0, "grid": "32UPU9165734903"},
                ]
            },
            (422, "bad_geometry", "control_points"),
        ),
    ],
)
def test_what_says_no_place_is_refused(control, body, refusal):
    line = control.open()
    assert line.refused("PUT", "/georeference", body) == refusal
    assert line.refused("GET", "/georeference")[0] == 404


def test_near_a_pole_there_is_no_grid(control):
    line = control.open()
    line.call("PUT", "/georeference", {"origin": {"lat_deg": -89.0, "lon_deg": 10.0}, "yaw_rad": 0.0})
    place = line.get("/georeference/place?x_m=10&y_m=0")
    assert (place["grid"], place["utm"]) == (None, None)
    assert hypot(place["lat_deg"] + 89.0, 0.0) < 1e-3
