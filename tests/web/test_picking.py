"""What a click into the scene means: the thing nearest in the picture, else the sector on the floor."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from web.viser.marks import mark_of
from web.viser.picking import SOLIDS, pick
from web.viser.places import centre_of, contains, photo_places, place_of

REACH = 0.01
VICTIM = {"x_m": 3.0, "y_m": 1.0, "merged_into": None}
VALUES: dict[str, dict[str, Any]] = {
    "robot/r1": {"x_m": 2.0, "y_m": -4.0},
    "tag/A1": {"x_m": 0.0, "y_m": 0.0},
    "tag/A2": {"x_m": 8.0, "y_m": 0.5},
    "victim/V1": VICTIM,
    "victim/V2": {"x_m": -3.0, "y_m": -1.0, "merged_into": "V1"},
    "annotation/n1": {"x_m": 6.0, "y_m": 6.0, "tag_id": None, "area_m": []},
    "annotation/n2": {"x_m": None, "y_m": None, "tag_id": "A2", "area_m": []},
    "annotation/n3": {"x_m": None, "y_m": None, "tag_id": None, "area_m": [[10, 10], [12, 10], [11, 13]]},
    "photo/p1": {"x_m": -6.0, "y_m": 6.0, "victim_id": None, "annotation_id": None, "tag_id": None},
    "photo/p2": {"x_m": None, "y_m": None, "victim_id": "V1", "annotation_id": None, "tag_id": None},
    "photo/p3": {"x_m": None, "y_m": None, "victim_id": "V1", "annotation_id": None, "tag_id": None},
    "sector/s1": {"area_m": [[-9, -9], [9, -9], [9, 9], [-9, 9]], "size_m2": 324.0},
    "sector/s2": {"area_m": [[4, 4], [7, 4], [7, 7], [4, 7]], "size_m2": 9.0},
    "links": {"pairs": [["A1", "A2"]]},
}


def towards(eye: Any, x_m: float, y_m: float, z_m: float = 0.0) -> Any:
    return np.array((x_m, y_m, z_m)) - eye


@given(
    st.sampled_from(["robot/r1", "tag/A1", "victim/V1", "annotation/n1", "annotation/n3", "photo/p1"]),
    st.floats(0.0, 2.0 * pi),
    st.floats(0.15, pi / 2.0),
    st.floats(2.0, 60.0),
    st.floats(0.0, 1.0),
)
def test_a_ray_at_any_part_of_a_thing_means_it(
    key: str, azimuth: float, height: float, distance_m: float, share: float
) -> None:
    kind, _, name = key.partition("/")
    kind = "note" if kind == "annotation" else kind
    alone = {key: VALUES[key], "tag/far": {"x_m": 500.0, "y_m": 500.0}}
    place = place_of(VALUES, kind, name)
    assert place is not None
    point = np.array((*place, share * SOLIDS[kind].height_m))
    out = np.array((np.cos(azimuth) * np.cos(height), np.sin(azimuth) * np.cos(height), np.sin(height)))
    eye = point + distance_m * out
    assert pick(alone, eye, -3.0 * out, 1e-6) == (kind, name)
    assert pick(alone, eye, out, REACH) is None, "it is behind the eye"


def test_a_click_may_pass_beside_by_the_reach_and_no_more() -> None:
    alone = {"tag/A1": VALUES["tag/A1"]}
    eye = np.array((0.0, 0.0, 20.05))
    for off_m, is_hit in ((0.16 + 0.19, True), (0.16 + 0.22, False)):  # 20 m off, 0.01 rad are 0.2 m
        assert (pick(alone, eye, towards(eye, off_m, 0.0, 0.05), REACH) is not None) is is_hit


def test_of_two_the_one_nearer_in_the_picture_is_meant_and_then_the_one_in_front() -> None:
    eye = np.array((0.0, -10.0, 5.0))
    pair = {"tag/left": {"x_m": -0.2, "y_m": 0.0}, "tag/right": {"x_m": 0.2, "y_m": 0.0}}
    assert pick(pair, eye, towards(eye, 0.06, 0.0), 0.1) == ("tag", "right")
    row = {"victim/back": VICTIM | {"y_m": 4.0}, "victim/front": VICTIM | {"y_m": 2.0}}
    low = np.array((3.0, -10.0, 1.0))
    assert pick(row, low, towards(low, 3.0, 2.0, 1.0), REACH) == ("victim", "front")


def test_the_floor_means_the_smallest_sector_there() -> None:
    eye = np.array((5.0, 5.0, 30.0))
    assert pick(VALUES, eye, towards(eye, 4.5, 4.5), REACH) == ("sector", "s2")
    assert pick(VALUES, eye, towards(eye, -5.0, -8.0), REACH) == ("sector", "s1")
    assert pick(VALUES, eye, towards(eye, 40.0, 0.0), REACH) is None
    assert pick(VALUES, eye, (1.0, 0.0, 0.2), REACH) is None, "it goes to the sky"


def test_merged_victims_are_not_there_and_photos_are_where_their_thing_is() -> None:
    eye = np.array((-3.0, -1.0, 30.0))
    assert pick(VALUES, eye, (0.0, 0.0, -1.0), REACH) == ("sector", "s1")
    assert photo_places(VALUES) == {"p1": ((-6.0, 6.0), 1), "p2": ((3.45, 0.55), 2)}
    assert place_of(VALUES, "note", "n2") == (8.0, 0.5)
    assert place_of(VALUES, "note", "n3") == (11.0, 11.0)
    assert place_of(VALUES, "links", "x") is None


@pytest.mark.parametrize(
    ("origin", "direction"),
    [((float("nan"), 0, 5), (0, 0, -1)), ((0, 0, 5), (0, 0, 0)), ((0, 0, 5), (float("inf"), 0, -1))],
)
def test_a_ray_that_is_none_means_nothing(origin: Any, direction: Any) -> None:
    assert pick(VALUES, origin, direction, REACH) is None


def test_an_area_contains_its_centre_and_not_what_is_outside() -> None:
    area = VALUES["sector/s2"]["area_m"]
    assert contains(area, *centre_of(area))
    assert not contains(area, 3.9, 5.0)


def test_a_mark_is_where_the_thing_is_and_goes_with_it() -> None:
    mark = mark_of(VALUES, ("tag", "A1"))
    assert mark is not None
    assert (mark.place, mark.label) == ((0.0, 0.0), "A1")
    assert mark_of(VALUES, ("tag", "gone")) is None
    assert mark_of(VALUES, None) is None
    outline = mark_of(VALUES, ("sector", "s2"))
    assert outline is not None
    assert outline.corners_m == ((4, 4), (7, 4), (7, 7), (4, 7))
