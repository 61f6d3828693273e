"""What is written into a tag: the window, its cells, and what is refused on reading."""

import numpy as np
import pytest

from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.sim.scenario import ScenarioConfig
from robots.tags.content import decode_memory, encode_memory, merge_bytes
from robots.tags.memory import (
    CLOSED,
    OPEN,
    SIDE,
    UNSEEN,
    TagMemory,
    TagMemoryError,
    observed_memory,
    side_for,
)

MIDDLE = SIDE // 2


def grid_of(cells: np.ndarray, origin=(-20.0, -20.0)) -> PlanGrid:
    return PlanGrid(cells, np.zeros_like(cells), origin, 0.1)


def known_block(x0: float, y0: float, x1: float, y1: float, state: int = FREE) -> np.ndarray:
    """A map of 40 m by 40 m round (0, 0) with one known block."""
    cells = np.full((400, 400), UNKNOWN, np.uint8)
    cells[round((y0 + 20) * 10) : round((y1 + 20) * 10), round((x0 + 20) * 10) : round((x1 + 20) * 10)] = (
        state
    )
    return cells


def test_no_bytes_are_an_empty_memory():
    assert decode_memory(b"") == TagMemory.empty()
    assert not TagMemory.empty().cells.any()


def test_a_tag_of_2048_bits_holds_the_largest_window():
    assert side_for(ScenarioConfig().tag_room_bytes) == SIDE
    assert len(encode_memory(TagMemory(np.full((SIDE, SIDE), CLOSED, np.uint8)))) == 195


def test_smaller_tags_hold_smaller_windows_and_the_middle_stays():
    rooms = {512: 3, 896: 15, 1152: 21, 2048: 31, 4032: 31}
    for bits, side in rooms.items():
        room = ScenarioConfig(tag_bits=bits).tag_room_bytes
        assert side_for(room) == side
        cells = np.zeros((SIDE, SIDE), np.uint8)
        cells[MIDDLE, MIDDLE + side // 2] = OPEN
        fitted = TagMemory(cells).fit(room)
        assert len(encode_memory(fitted)) <= room
        assert fitted == TagMemory(cells)


def test_the_bytes_are_version_side_and_five_cells_each():
    cells = np.zeros((3, 3), np.uint8)
    cells[0] = [CLOSED, OPEN, UNSEEN]
    cells[1, 0] = CLOSED
    data = encode_memory(TagMemory(cells))
    assert data == bytes([3, 3, 2 + 3 * 1 + 27 * 2, 0])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x01", "begins with 3, its version; this one with 1"),
        (b"\x03", "has 0 cells along a side"),
        (bytes([3, 4, 0, 0, 0, 0]), "has 4 cells along a side"),
        (bytes([3, 33]) + bytes(300), "has 33 cells along a side"),
        (encode_memory(TagMemory(np.zeros((5, 5), np.uint8)))[:-1], "ends after 6 bytes of 7 or more"),
        (bytes([3, 1, 255]), "a state that does not exist"),
        (bytes([3, 1, 3]), "cells beyond its window"),
        (bytes([3, 1, 0, 9]), "cut off or damaged"),
        (bytes([3]) + bytes(70_000), "at most 65536 bytes"),
    ],
)
def test_damaged_memories_are_refused(data, message):
    with pytest.raises(TagMemoryError, match=message):
        decode_memory(data)
    with pytest.raises(TagMemoryError):
        merge_bytes(encode_memory(TagMemory.empty()), data)


def test_equal_memories_are_equal_and_hash_alike():
    a, b = TagMemory(np.zeros((1, 1), np.uint8)), TagMemory(np.zeros((9, 9), np.uint8))
    assert a == b  # rings that say nothing do not count
    assert hash(a) == hash(b)
    b.cells[3, 4] = OPEN
    assert a != b
    assert a != "no memory"


def test_rows_go_north_and_columns_west():
    memory = observed_memory(grid_of(known_block(3.0, -2.0, 6.0, 1.0)), 0.5, 0.5)
    # metres north (x) and west (y) of the tag's own cell
    seen = {(int(i) - MIDDLE, int(j) - MIDDLE) for i, j in np.argwhere(memory.cells != UNSEEN)}
    assert seen == {(north, west) for north in (3, 4, 5) for west in (-2, -1, 0)}


def test_cells_at_the_edge_of_the_known_are_open_and_inside_it_closed():
    memory = observed_memory(grid_of(known_block(-3.0, -3.0, 4.0, 4.0)), 0.5, 0.5)
    window = memory.cells[MIDDLE - 3 : MIDDLE + 4, MIDDLE - 3 : MIDDLE + 4]
    np.testing.assert_array_equal(window[1:-1, 1:-1], CLOSED)
    for rim in (window[0], window[-1], window[:, 0], window[:, -1]):
        np.testing.assert_array_equal(rim, OPEN)


def test_walls_close_the_ground_behind_them():
    cells = known_block(-3.0, -3.0, 4.0, 4.0)
    cells[170, 170:240] = cells[239, 170:240] = OCCUPIED
    cells[170:240, 170] = cells[170:240, 239] = OCCUPIED
    memory = observed_memory(grid_of(cells), 0.5, 0.5)
    np.testing.assert_array_equal(memory.cells[MIDDLE - 3 : MIDDLE + 4, MIDDLE - 3 : MIDDLE + 4], CLOSED)


@pytest.mark.parametrize(("width", "state"), [(0.4, UNSEEN), (0.6, CLOSED)])
def test_a_cell_counts_when_half_of_it_is_known(width, state):
    memory = observed_memory(grid_of(known_block(0.0, 0.0, width, 1.0, OCCUPIED)), 0.5, 0.5)
    assert memory.cells[MIDDLE, MIDDLE] == state


def test_ground_outside_the_window_or_the_map_is_left_out():
    cells = np.full((60, 60), FREE, np.uint8)  # 6 m by 6 m, all known
    memory = observed_memory(grid_of(cells, (-3.0, -3.0)), 0.5, 0.5)
    assert (memory.cells == CLOSED).sum() == 36
    assert not observed_memory(grid_of(cells, (30.0, 0.0)), 0.5, 0.5).cells.any()


def test_two_visits_from_two_sides_know_what_either_knows():
    north = observed_memory(grid_of(known_block(1.0, -3.0, 5.0, 3.0)), 0.5, 0.5)
    south = observed_memory(grid_of(known_block(-5.0, -3.0, 1.0, 3.0)), 0.5, 0.5)
    both = north.merge(south)
    assert (both.cells != UNSEEN).sum() == (north.cells != UNSEEN).sum() + (south.cells != UNSEEN).sum()
