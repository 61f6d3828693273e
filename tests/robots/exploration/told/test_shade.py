"""What is not worth going to though nobody told of it: strips behind walls, and crumbs."""

import numpy as np

from robots.exploration.told.shade import shaded
from robots.tags.memory import CLOSED, OPEN, UNSEEN


def lattice(*boxes: tuple[int, int, int, int, int]) -> np.ndarray:
    """30 x 30 cells nobody told of, with boxes (top, left, bottom, right, state)."""
    cells = np.full((30, 30), UNSEEN, np.uint8)
    for top, left, bottom, right, state in boxes:
        cells[top:bottom, left:right] = state
    return cells


UNKNOWN = np.ones((30, 30))


def test_without_covered_ground_nothing_is_shaded():
    assert not shaded(lattice((5, 5, 9, 9, OPEN)), UNKNOWN, True).any()


def test_a_metre_along_covered_ground_is_shaded_and_its_open_edge_is_not():
    shade = shaded(lattice((10, 10, 20, 20, CLOSED), (10, 18, 20, 22, OPEN)), UNKNOWN, True)
    assert shade[15, 8:10].all()
    assert not shade[15, 7]
    assert not shade[10:20, 18:23].any()
    assert not shade[10:20, 10:18].any()  # covered, not in the shade


def test_a_crumb_in_covered_ground_is_shaded_and_a_room_is_not():
    crumb = shaded(lattice((2, 2, 28, 28, CLOSED), (10, 10, 12, 14, UNSEEN)), UNKNOWN, True)
    assert crumb[10:12, 10:14].all()
    room = shaded(lattice((2, 2, 28, 28, CLOSED), (8, 8, 16, 16, UNSEEN)), UNKNOWN, True)
    assert not room[10:14, 10:14].any()


def test_what_the_robot_knows_itself_does_not_make_a_crumb_larger():
    unknown = UNKNOWN.copy()
    unknown[10:14, 11:14] = 0.0
    assert shaded(lattice((2, 2, 28, 28, CLOSED), (10, 10, 14, 14, OPEN)), unknown, False)[10:14, 10].all()


def test_an_open_crumb_may_lead_on_where_tags_are_read_from_afar():
    """The mouth of a corridor, the one way to all the rest of an office that was never entered."""
    mouth = lattice((2, 2, 20, 28, CLOSED), (18, 14, 20, 16, OPEN))
    assert not shaded(mouth, UNKNOWN, True)[18:20, 14:16].any()
    assert shaded(mouth, UNKNOWN, True)[20:22, 14:16].all()  # what lies behind it nobody told of
    assert shaded(mouth, UNKNOWN, False)[18:20, 14:16].all()  # read under its feet: its writer went there
