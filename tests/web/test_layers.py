"""The layers' geometry, exact for small cases, and what a scene draws when."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from web.viser.colors import THEMES
from web.viser.frontiers_layer import segments
from web.viser.map_layer import WALL_HEIGHT_M, floor_image, wall_boxes
from web.viser.scene import MissionScene
from web.viser.shapes import Mesh, ellipse, prism, unit_box, unit_disc


@pytest.fixture
def scene() -> Iterator[MissionScene]:
    scene = MissionScene()
    yield scene
    scene.stop()


def node(scene: MissionScene, name: str) -> Any:
    return scene._server.scene.get_handle_by_name(name)


def test_walls_of_a_small_room_are_four_boxes() -> None:
    cells = np.zeros((4, 5), np.int8)
    cells[0, :] = cells[-1, :] = 100
    cells[:, 0] = cells[:, -1] = 100
    cells[1, 2] = -1
    assert sorted(map(tuple, wall_boxes(cells))) == [(0, 0, 5, 1), (0, 1, 1, 2), (0, 3, 5, 1), (4, 1, 1, 2)]


def test_doubtful_and_unknown_cells_are_no_walls() -> None:
    assert wall_boxes(np.array([[-1, 0, 64]], np.int8)).shape == (0, 4)
    assert wall_boxes(np.array([[-1, 0, 65]], np.int8)).tolist() == [[2, 0, 1, 1]]


@given(
    npst.arrays(
        np.int8, npst.array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.integers(-1, 100)
    )
)
def test_boxes_cover_each_occupied_cell_exactly_once(cells: np.ndarray) -> None:
    covered = np.zeros(cells.shape, int)
    for column, row, width, height in wall_boxes(cells):
        covered[row : row + height, column : column + width] += 1
    np.testing.assert_array_equal(covered, cells >= 65)


def test_the_floor_has_its_first_row_at_the_far_side() -> None:
    floor = THEMES["dark"]["floor"]
    image = floor_image(np.array([[0, -1], [-1, -1]], np.int8), floor)
    assert image[1, 0].tolist() == [*floor, 255]
    assert image[..., 3].sum() == 255


@pytest.mark.parametrize(
    "mesh",
    [
        unit_box(),
        prism([(1, 0), (0, 1), (-1, 0), (0, -1)], 1.0),
        unit_disc(),
        prism([(0.6, 0), (-0.4, 0.4), (-0.4, -0.4)], 0.3),
    ],
)
def test_every_face_looks_outwards(mesh: Mesh) -> None:
    a, b, c = (mesh.vertices[mesh.faces[:, i]].astype(float) for i in range(3))
    normals = np.cross(b - a, c - a)
    assert (np.linalg.norm(normals, axis=1) > 1e-9).all()
    inside = mesh.vertices.mean(axis=0) - (0.0, 0.0, 0.1)
    assert ((normals * ((a + b + c) / 3.0 - inside)).sum(axis=1) > 0).all()


def test_ellipse_of_a_turned_covariance() -> None:
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    covariance = turn @ np.diag([0.09, 0.01]) @ turn.T
    shape = ellipse(covariance[0, 0], covariance[0, 1], covariance[1, 1])
    assert shape == pytest.approx((0.6, 0.2, 0.4))
    assert ellipse(0.01, 0.0, 0.09).angle_rad == pytest.approx(pi / 2)


def test_walls_stand_where_the_grid_says(scene: MissionScene) -> None:
    scene.update_map(np.array([[100, 100, 0], [-1, 100, -1]], np.int8), (-1.0, 3.0), 0.5)
    scene.draw(scene.take(10.0))
    walls = node(scene, "/map/walls")
    np.testing.assert_allclose(walls.batched_positions, [[-1.0, 3.0, 0.0], [-0.5, 3.5, 0.0]])
    np.testing.assert_allclose(walls.batched_scales, [[1.0, 0.5, WALL_HEIGHT_M], [0.5, 0.5, WALL_HEIGHT_M]])
    floor = node(scene, "/map/floor")
    assert tuple(floor.position) == pytest.approx((-0.25, 3.5, 0.0))
    assert (floor.render_width, floor.render_height) == (1.5, 1.0)


def test_walls_go_when_the_map_has_none_any_more(scene: MissionScene) -> None:
    scene.update_map(np.array([[100]], np.int8), (0.0, 0.0), 0.5)
    scene.draw(scene.take(10.0))
    scene.update_map(np.array([[0]], np.int8), (0.0, 0.0), 0.5)
    scene.draw(scene.take(20.0))
    assert node(scene, "/map/walls") is None


def test_a_silent_robot_turns_grey_and_a_removed_one_goes(scene: MissionScene) -> None:
    robot = {"x_m": 1.0, "y_m": 2.0, "yaw_rad": pi / 2, "covariance": [0.04, 0.0, 0.01, 0.1], "link": "live"}
    scene.put("robot/a/../b", robot)
    scene.draw(scene.take(10.0))
    body, disc = node(scene, "/robots/1/body"), node(scene, "/ellipses/1")
    own_color = body.color
    assert tuple(node(scene, "/robots/1").position[:2]) == (1.0, 2.0)
    assert disc.scale == pytest.approx((0.4, 0.2, 1.0))
    scene.put("robot/a/../b", robot | {"link": "lost"})
    scene.draw(scene.take(10.1))
    assert body.color != own_color
    scene.put("robot/a/../b", None)
    scene.draw(scene.take(10.2))
    assert node(scene, "/robots/1") is None
    assert node(scene, "/ellipses/1") is None


def test_poses_are_drawn_often_and_trails_once_a_second(scene: MissionScene) -> None:
    robot = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "covariance": [0.0, 0.0, 0.0, 0.0], "link": "live"}
    scene.draw(scene.take(10.0))
    scene.put("robot/r1", robot)
    scene.put("trail/r1", {"points_m": [[0.0, 0.0], [1.0, 0.0]]})
    soon = scene.take(10.1)
    assert set(soon.values) == {"robot/r1"}
    assert set(scene.take(10.2).values) == set()
    assert set(scene.take(11.1).values) == {"trail/r1"}


def test_a_new_board_removes_what_it_does_not_have(scene: MissionScene) -> None:
    tag = {"x_m": 0.0, "y_m": 0.0}
    scene.replace({"tag/A": tag, "tag/B": tag, "links": {"pairs": [["A", "B"], ["A", "gone"]]}})
    scene.draw(scene.take(10.0))
    assert len(node(scene, "/tags/points").batched_positions) == 2
    assert len(node(scene, "/tags/links").points) == 1
    scene.replace({"tag/A": tag})
    scene.draw(scene.take(20.0))
    assert len(node(scene, "/tags/points").batched_positions) == 1
    assert node(scene, "/tags/links") is None


def test_nodes_have_masts_and_the_most_urgent_alert_of_each_a_pin(scene: MissionScene) -> None:
    tag = {"x_m": 1.0, "y_m": 2.0}
    reading = {"temperature_c": 85.0, "pressure_hpa": 1013.0, "tilt_rad": 0.0}
    hot = {"tag_id": "A", "kind": "hot", "severity": "alarm", "acknowledged_unix_s": None}
    tilted = hot | {"kind": "tilted", "severity": "warning"}
    lost = hot | {"tag_id": "C"}
    scene.replace(
        {
            "tag/A": tag,
            "tag/B": tag,
            "node/A": reading,
            "node/C": reading,
            "alert/hot:A": hot,
            "alert/tilted:A": tilted,
            "alert/hot:C": lost,
        }
    )
    scene.draw(scene.take(10.0))
    assert len(node(scene, "/nodes/masts").batched_positions) == 1  # nobody knows where C is
    assert node(scene, "/nodes/alerts/1/label").text == "A  85 °C"
    assert tuple(node(scene, "/nodes/alerts/1").position) == (1.0, 2.0, 0.0)
    assert node(scene, "/nodes/alerts/2") is None
    scene.put("alert/hot:A", hot | {"acknowledged_unix_s": 5.0})
    scene.draw(scene.take(20.0))
    assert node(scene, "/nodes/alerts/1/label").text == "A  knocked over"
    scene.put("alert/hot:A", None)
    scene.put("alert/tilted:A", None)
    scene.draw(scene.take(30.0))
    assert node(scene, "/nodes/alerts/1") is None


def test_edges_of_the_unknown_are_rings_with_a_mast_where_the_robot_goes(scene: MissionScene) -> None:
    ring, chosen = segments(3.0, 4.0, False), segments(3.0, 4.0, True)
    assert ring.shape == (12, 2, 3)
    np.testing.assert_allclose(np.hypot(*(ring[:, 0, :2] - [3.0, 4.0]).T), 0.18, atol=1e-6)
    np.testing.assert_allclose(chosen[-1, :, :2], [[3.0, 4.0]] * 2)
    edges = [{"x_m": 1.0, "y_m": 2.0, "length_m": 1.2, "worth_m": -3.0, "chosen": True}]
    scene.put("frontiers/r1", {"robot_id": "r1", "frontiers": edges})
    scene.draw(scene.take(10.0))
    assert node(scene, "/frontiers/1") is not None
    scene.put("frontiers/r1", {"robot_id": "r1", "frontiers": []})
    scene.draw(scene.take(20.0))
    assert node(scene, "/frontiers/1") is None
