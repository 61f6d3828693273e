"""Base map, notes, sectors and photos in the scene: what is drawn, where, and what goes again."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from web.viser.base_layer import thinned
from web.viser.colors import THEMES
from web.viser.map_layer import Grid
from web.viser.scene import MissionScene
from web.viser.shapes import dashed, outline

EVIL = "<img src=x onerror=alert(1)> **bold** [a](javascript:alert(1))"
NOTE = {"kind": "hazard", "text": EVIL, "x_m": 1.0, "y_m": 2.0, "tag_id": None, "area_m": []}
SECTOR = {
    "name": "B2", "status": "under_way", "robots": ["r1"], "team": "AUS01", "size_m2": 12.0,
    "area_m": [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]],
}  # fmt: skip
PHOTO = {"victim_id": None, "annotation_id": None, "tag_id": "A", "x_m": None, "y_m": None}


@pytest.fixture
def scene() -> Iterator[MissionScene]:
    scene = MissionScene()
    yield scene
    scene.stop()


def node(scene: MissionScene, name: str) -> Any:
    return scene._server.scene.get_handle_by_name(name)


def draw(scene: MissionScene, now_s: float, **values: Any) -> None:
    scene.replace({key.replace("_", "/", 1): value for key, value in values.items()})
    scene.draw(scene.take(now_s))


def test_a_base_map_lies_under_the_floor_and_goes_when_it_is_taken_away(scene: MissionScene) -> None:
    grid = Grid(np.array([[0, 100, -1], [0, 0, -1]], np.int8), (-3.0, 5.0), 0.5)
    scene.update_base(grid)
    scene.draw(scene.take(10.0))
    plan = node(scene, "/base")
    assert tuple(plan.position) == pytest.approx((-2.25, 5.5, -0.05))
    assert (plan.render_width, plan.render_height) == (1.5, 1.0)
    assert tuple(plan.image[1, 1]) == (*THEMES["dark"]["wall"], 102), "row 0 of the picture is the far side"
    assert plan.image[:, 2, 3].tolist() == [0, 0]
    scene.update_base(None)
    scene.draw(scene.take(20.0))
    assert node(scene, "/base") is None


@given(
    npst.arrays(
        np.int8, npst.array_shapes(min_dims=2, max_dims=2, max_side=14), elements=st.integers(-1, 100)
    ),
    st.integers(1, 6),
)
def test_a_thinned_map_keeps_every_wall_in_its_place(cells: np.ndarray, most: int) -> None:
    thin = thinned(Grid(cells, (1.0, 2.0), 0.25), most)
    assert max(thin.cells.shape) <= most
    by = round(thin.resolution_m / 0.25)
    rows, columns = np.nonzero(cells >= 65)
    assert (thin.cells[rows // by, columns // by] >= 65).all()
    assert (thin.cells >= 65).sum() <= len(rows)
    assert thin.origin_m == (1.0, 2.0)


def test_notes_stand_at_their_place_and_go_with_their_tag(scene: MissionScene) -> None:
    at_tag = NOTE | {"kind": "note", "text": "", "x_m": None, "y_m": None, "tag_id": "A"}
    lost = at_tag | {"tag_id": "gone"}
    draw(
        scene,
        10.0,
        tag_A={"x_m": 3.0, "y_m": 4.0},
        annotation_n1=NOTE,
        annotation_n2=at_tag,
        annotation_n3=lost,
    )
    assert tuple(node(scene, "/notes/1").position[:2]) == (1.0, 2.0)
    assert tuple(node(scene, "/notes/2").position[:2]) == (3.0, 4.0)
    assert node(scene, "/notes/2/label").text == "note"
    assert node(scene, "/notes/3") is None, "nobody knows where that is"
    draw(scene, 20.0, tag_A={"x_m": 5.0, "y_m": 4.0}, annotation_n2=at_tag)
    assert tuple(node(scene, "/notes/2").position[:2]) == (5.0, 4.0)
    assert node(scene, "/notes/1") is None


def test_an_area_is_outlined_where_it_lies(scene: MissionScene) -> None:
    area = [[4.0, 4.0], [6.0, 4.0], [6.0, 6.0], [4.0, 6.0]]
    draw(scene, 10.0, annotation_n1=NOTE | {"x_m": None, "y_m": None, "area_m": area})
    frame, around = node(scene, "/notes/1"), node(scene, "/notes/1/area")
    np.testing.assert_allclose(around.points[:, 0, :2] + frame.position[:2], area)


def test_sectors_say_who_is_on_them_and_are_whole_lines_once_searched(scene: MissionScene) -> None:
    draw(scene, 10.0, sector_s=SECTOR)
    assert node(scene, "/sectors/1/label").text == "▶ B2 · r1, AUS01"
    assert len(node(scene, "/sectors/1/outline").points) > 4
    draw(scene, 20.0, sector_s=SECTOR | {"status": "searched", "robots": [], "team": ""})
    assert node(scene, "/sectors/1/label").text == "✓ B2"
    np.testing.assert_allclose(node(scene, "/sectors/1/outline").points[:, 0, :2], SECTOR["area_m"])
    draw(scene, 30.0)
    assert node(scene, "/sectors/1") is None
    assert node(scene, "/sectors/1/outline") is None


def test_photos_stand_beside_what_they_show_with_their_number(scene: MissionScene) -> None:
    draw(scene, 10.0, tag_A={"x_m": 3.0, "y_m": 4.0}, photo_p1=PHOTO, photo_p2=PHOTO)
    assert tuple(node(scene, "/photos/1").position[:2]) == pytest.approx((3.45, 3.55))
    assert node(scene, "/photos/1/label").text == "2 photos"
    assert node(scene, "/photos/2") is None
    draw(scene, 20.0, tag_A={"x_m": 3.0, "y_m": 4.0}, photo_p2=PHOTO)
    assert node(scene, "/photos/1") is None
    assert node(scene, "/photos/2/label") is None


def test_a_merged_victim_is_not_drawn(scene: MissionScene) -> None:
    victim = {"x_m": 1.0, "y_m": 1.0, "status": "suspected", "confidence": 0.5, "merged_into": None}
    draw(scene, 10.0, victim_V1=victim)
    assert node(scene, "/victims/1") is not None
    draw(scene, 20.0, victim_V1=victim | {"merged_into": "V2"})
    assert node(scene, "/victims/1") is None


def test_words_of_people_reach_viser_as_labels_alone(scene: MissionScene) -> None:
    """The contract with viser 1.1.1: labels are drawn as glyphs, HTML and markdown are never used."""
    words = {
        "annotation_n1": NOTE,
        "sector_s": SECTOR | {"name": EVIL, "team": EVIL},
        "victim_" + EVIL: {"x_m": 1.0, "y_m": 1.0, "status": "suspected", "confidence": 0.5},
        "robot_" + EVIL: {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "covariance": [0, 0, 0, 0], "link": "live"},
    }
    draw(scene, 10.0, **words)
    sent = scene._server._websock_server._broadcast_buffer.message_from_id.values()
    having = {type(message).__name__ for message in sent if "onerror" in repr(message)}
    assert having == {"LabelMessage"}
    assert len(node(scene, "/notes/1/label").text) == 40


@given(st.floats(0.01, 500.0))
def test_dashes_begin_and_end_with_the_line_and_leave_gaps(length_m: float) -> None:
    line = np.array([[[1.0, 1.0, 0.0], [1.0, 1.0 + length_m, 0.0]]], np.float32)
    cut = dashed(line)
    np.testing.assert_allclose(cut[0, 0], line[0, 0], atol=1e-4)
    np.testing.assert_allclose(cut[-1, 1], line[0, 1], rtol=1e-5, atol=1e-4)
    assert len(cut) <= 200
    assert (cut[1:, 0, 1] >= cut[:-1, 1, 1]).all()
    assert len(outline(np.zeros((5, 2)), 0.0)) == 5
