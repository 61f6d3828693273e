"""Of what kind a place is: drawn corridors, rooms, doorways, halls, and what a map does not tell."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import ndimage

from robots.routes.place_kind import kind_of
from robots.team import TeamGrid

CELL_M, WALL_M = 0.1, 0.15
turns = st.floats(-pi, pi)
shares = st.floats(0.0, 1.0)


class Drawing:
    """Rectangles ``x0, y0, x1, y1`` of free floor on a sheet turned by ``yaw``, walled or ``is_open``."""

    def __init__(self, yaw, floor, things=(), is_open=False):
        self.turn = np.array([[cos(yaw), -sin(yaw)], [sin(yaw), cos(yaw)]])
        corners = np.array([[(x, y) for x in box[::2] for y in box[1::2]] for box in floor]).reshape(-1, 2)
        corners = corners @ self.turn.T
        self.origin = corners.min(axis=0) - 1.0
        count = np.ceil((corners.max(axis=0) + 1.0 - self.origin) / CELL_M).astype(int)
        rows, columns = np.mgrid[: count[1], : count[0]]
        points = (np.stack([columns, rows], axis=-1) + 0.5) * CELL_M + self.origin
        points = points @ self.turn
        free, thing = (self.inside(points, boxes) for boxes in (floor, things))
        near = ndimage.distance_transform_edt(~free) * CELL_M <= WALL_M
        cells = np.where(free, 0, np.where(near & (not is_open), 100, -1))
        edge = thing & ndimage.binary_dilation(~thing)
        cells[thing] = np.where(edge, 100, -1)[thing]
        self.grid = TeamGrid(cells.astype(np.int8), tuple(self.origin), CELL_M, 1)

    @staticmethod
    def inside(points, boxes):
        found = np.zeros(points.shape[:2], bool)
        for x0, y0, x1, y1 in boxes:
            x, y = points[..., 0], points[..., 1]
            found |= (x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)
        return found

    def kind(self, x, y):
        """The kind of a place on the sheet."""
        return kind_of(self.grid, *(self.turn @ (x, y)))


@given(turns, st.floats(1.0, 2.9), st.floats(1.0, 2.0), shares, shares, st.integers(0, 2**31))
def test_between_two_walls_it_is_a_corridor(yaw, wide, longer, along, across, seed):
    long = longer * max(7.0, 3.5 * wide)
    rng = np.random.default_rng(seed)
    floor = [(0.0, 0.0, long, wide)]
    for x in np.arange(1.0, long - 4.0, 4.0):  # rooms to both sides, each with a door of 0.9 m somewhere
        for y0, y1, d0, d1 in ((wide + 0.3, wide + 4.0, wide, wide + 0.3), (-4.0, -0.3, -0.3, 0.0)):
            door = x + rng.uniform(0.1, 2.7)
            floor += [(x, y0, x + 3.7, y1), (door, d0, door + 0.9, d1)]
    x, y = 0.5 + along * (long - 1.0), 0.3 + across * (wide - 0.6)
    assert Drawing(yaw, floor).kind(x, y) == "corridor"


@given(turns, st.floats(2.4, 8.0), st.floats(1.0, 1.8), st.floats(0.8, 1.2), shares, shares, shares)
def test_what_is_closed_but_for_its_door_is_a_room(yaw, wide, longer, door, at, along, across):
    long = min(9.0, longer * wide)
    start = 0.2 + at * (long - door - 0.4)
    outside = (-3.0, -2.3, long + 3.0, -0.3)
    floor = [(0.0, 0.0, long, wide), (start, -0.3, start + door, 0.0), outside]
    x, y = 0.5 + along * (long - 1.0), 0.6 + across * (wide - 1.1)
    table = [(long / 2 - 0.6, wide / 2 - 0.4, long / 2 + 0.6, wide / 2 + 0.4)] if wide > 4.0 else []
    assume(not table or abs(x - long / 2) > 0.9 or abs(y - wide / 2) > 0.7)
    assert Drawing(yaw, floor, table).kind(x, y) == "room"


@given(turns, st.floats(0.75, 1.2), st.floats(0.15, 0.4), st.floats(-0.15, 0.15), shares)
def test_where_two_rooms_are_joined_it_is_a_doorway(yaw, door, thick, off, at):
    start = 0.6 + at * (3.8 - door - 1.2)
    floor = [(0.0, thick, 4.0, 4.0), (0.0, -3.0, 4.0, 0.0), (start, 0.0, start + door, thick)]
    assert Drawing(yaw, floor).kind(start + door / 2 + off, thick / 2 + off / 2) == "doorway"


@given(turns, st.floats(13.0, 25.0), shares, shares)
def test_among_pillars_of_a_hall_it_is_an_open_area(yaw, side, along, across):
    pillars = [
        (x, y, x + 0.6, y + 0.6) for x in np.arange(3, side - 2, 4.5) for y in np.arange(3, side - 2, 4.5)
    ]
    x, y = 1.0 + along * (side - 2.0), 1.0 + across * (side - 2.0)
    assume(not any(x0 - 0.3 < x < x1 + 0.3 and y0 - 0.3 < y < y1 + 0.3 for x0, y0, x1, y1 in pillars))
    assert Drawing(yaw, [(0.0, 0.0, side, side)], pillars).kind(x, y) == "open_area"


@given(turns, st.floats(1.5, 8.0), st.floats(1.5, 8.0), shares, shares)
def test_where_walls_have_not_been_seen_nothing_is_said(yaw, long, wide, along, across):
    seen = Drawing(yaw, [(0.0, 0.0, long, wide)], is_open=True)
    assert seen.kind(along * long, across * wide) == ""


@given(turns, shares)
def test_a_gap_that_one_can_walk_round_is_no_doorway(yaw, at):
    cabinet = [(1.2 + at, 2.0, 3.4 + at, 2.6)]  # to one side of it a gap of about a metre is left
    assert Drawing(yaw, [(0.0, 0.0, 6.0, 5.0)], cabinet).kind(0.6 + at / 2, 2.3) != "doorway"


@pytest.mark.parametrize("place", [(-0.08, 2.0), (-40.0, 2.0), (2.0, 400.0)])
def test_in_a_wall_and_off_the_map_nothing_is_said(place):
    assert Drawing(0.0, [(0.0, 0.0, 4.0, 4.0)]).kind(*place) == ""


def test_an_empty_map_tells_nothing():
    assert kind_of(TeamGrid(np.zeros((0, 0), np.int8), (0.0, 0.0), 0.1, 1), 0.0, 0.0) == ""
