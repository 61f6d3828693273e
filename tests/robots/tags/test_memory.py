"""What is written into a tag: the window, its cells, and what is refused on reading."""

from dataclasses import replace

import numpy as np
import pytest

from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.sim.scenario import ScenarioConfig
from robots.tags.content import decode_memory, encode_memory, merge_bytes
from robots.tags.marks import Note, Notes, goal_mark, note_of, victim_mark
from robots.tags.memory import (
    CLOSED,
    OPEN,
    REACH,
    SIDE,
    UNSEEN,
    TagMemory,
    TagMemoryError,
    cell_of,
    phase_of,
    shift_of,
)
from robots.tags.observed import observed_memory, visited_window
from robots.tags.window import resized

MIDDLE = SIDE // 2


def seen_round(grid: PlanGrid, x: float, y: float) -> np.ndarray:
    return resized(observed_memory(grid, x, y).cells, SIDE)


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


def square(side: int, state: int = CLOSED) -> TagMemory:
    return TagMemory(np.full((side, side), state, np.uint8))


@pytest.mark.parametrize(
    ("bits", "side"), [(512, 1), (896, 15), (1152, 19), (2048, 29), (4032, 31), (7104, 43), (8192, 47)]
)
def test_a_larger_chip_has_room_for_a_larger_square(bits, side):
    room = ScenarioConfig(tag_bits=bits).tag_room_bytes
    fitted = square(SIDE).fit(room)
    assert fitted.side == side
    assert len(encode_memory(fitted)) <= room
    assert square(side).merge(fitted) == fitted
    assert fitted.fit(room) == fitted


def test_where_the_ground_lies_to_one_side_the_window_reaches_farther():
    cells = np.zeros((SIDE, SIDE), np.uint8)
    cells[REACH:, REACH - 2 : REACH + 24] = CLOSED  # 32 m to the north, 26 m across, from the tag's cell on
    assert TagMemory(cells).fit(ScenarioConfig().tag_room_bytes).cells.sum() == CLOSED * 32 * 26


def test_every_kind_has_room_in_2048_bits_and_victims_come_before_all():
    full = TagMemory(
        np.full((SIDE, SIDE), CLOSED, np.uint8),
        (),
        tuple(victim_mark(f"v{k}", 1.0 - 0.1 * k, 60.0 * k, -3.04, 12.5) for k in range(9)),
        Notes((Note(2, "Kim", "stairs are gone, use the yard"), Note(1, "Ada", "x" * 60))),
        tuple(goal_mark(f"r{k}", 9 - k, k, 3.2, -40.0) for k in range(9)),
        np.full((21, 21), 1, np.uint8),
    )
    room = ScenarioConfig().tag_room_bytes
    kept = full.fit(room)
    assert len(encode_memory(kept)) <= room
    assert (len(kept.victims), len(kept.notes.notes), len(kept.passes)) == (4, 1, 4)
    assert (kept.victims[0].confidence, kept.victims[0].north_dm, kept.victims[0].west_dm) == (255, -30, 125)
    assert kept.passes[0].goal_m == (3.0, -40.0)
    assert kept.notes.notes[0].author == "Kim"
    assert (len(kept.visited), kept.side) == (15, 11)
    assert full.fit(4056).notes == full.notes
    assert full.fit(4056).side == SIDE


def test_frontiers_and_visited_places_are_metres_from_the_tag():
    memory = square(3)
    memory.cells[2, 0] = OPEN
    memory = replace(memory, visited=visited_window(np.array([(5.0, 5.0), (5.0, 5.3), (5.3, 5.3)]), 5.0, 5.0))
    np.testing.assert_allclose(memory.frontiers_m, [(1.0, -1.0)])
    np.testing.assert_allclose(replace(memory, phase=0).frontiers_m, [(1.5, -0.5)])
    np.testing.assert_allclose(memory.visited_m, [(0.0, 0.0), (0.0, 0.4), (0.4, 0.4)], atol=1e-9)


def test_a_place_that_was_left_and_entered_again_was_visited_twice():
    there_and_back = [(0.0, y) for y in (0.0, 0.1, 0.4, 0.8, 0.5, 0.0)]
    cells = visited_window(np.array(there_and_back), 0.0, 0.0)
    np.testing.assert_array_equal(cells[2], [0, 0, 2, 2, 1])
    assert not visited_window(np.zeros((0, 4)), 0.0, 0.0).any()
    assert not visited_window(np.array([(50.0, 0.0)]), 0.0, 0.0).any()


@pytest.mark.parametrize("phase", [0, 0x88, 0xFF, 0x3C, 0x188, 0x1C3, 0x288, 0x23C])
def test_tags_of_one_lattice_tell_of_the_same_cells(phase):
    rng = np.random.default_rng(7)
    cells = np.where(rng.random((400, 400)) < 0.6, FREE, UNKNOWN).astype(np.uint8)
    cell_m = cell_of(phase)
    corner = tuple(shift - cell_m / 2.0 for shift in shift_of(phase))  # of the cell of a tag at (0, 0)
    assert phase_of(0.0, 0.0, corner, cell_m) == phase
    near = observed_memory(grid_of(cells), 0.0, 0.0, phase)
    far = observed_memory(grid_of(cells), 3.25, -1.5, phase_of(3.25, -1.5, corner, cell_m))
    apart = (np.array((3.25, -1.5)) + far.shift_m - near.shift_m) / cell_m
    offset = np.rint(apart)
    np.testing.assert_allclose(offset, apart, atol=1e-9)
    north, west = offset.astype(int)
    a, b = resized(near.cells, SIDE), np.roll(resized(far.cells, SIDE), (north, west), (0, 1))
    np.testing.assert_array_equal(a[10:-10, 10:-10], b[10:-10, 10:-10])


def test_of_two_lattices_one_counts_and_an_empty_memory_has_none():
    ours, theirs = replace(square(3), phase=7), replace(square(5, OPEN), phase=200)
    assert ours.merge(theirs) == theirs == theirs.merge(ours)
    assert ours.merge(TagMemory.empty()) == ours


def test_the_bytes_are_what_follows_then_phase_reach_box_and_five_cells_each():
    cells = np.zeros((3, 3), np.uint8)
    cells[0] = [CLOSED, OPEN, UNSEEN]
    cells[1, 0] = CLOSED
    memory = TagMemory(cells, reach=1)
    assert encode_memory(memory) == bytes([0x50, 0x88, 2 * 2 + 1, 0 * 27 + 1 * 9 + 0 * 3 + 1, 2 + 3 + 9 * 2])
    assert encode_memory(TagMemory.empty()) == bytes([0x40])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x01", "begins with 64 to 127; this one with 1"),
        (b"\x50", "ends after 1 bytes"),
        (bytes([0x50, 0x88, 67]), "reaches -1 cells"),
        (bytes([0x50, 0x88, 198]), "a size 3 that does not exist"),
        (bytes([0x48, 66]), "a size 1 that does not exist"),
        (bytes([0x50, 0x88, 64]), "reaches 31 cells"),
        (bytes([0x50, 0x88, 5, 255]), "no such box"),
        (encode_memory(square(5))[:-1], "it ends after"),
        (bytes([0x50, 0x88, 3, 255]), "a state that does not exist"),
        (bytes([0x50, 0x88, 3, 3]), "cells beyond its window"),
        (bytes([0x50, 0x88, 5, 10, 1]), "larger than what it holds"),
        (bytes([0x40, 9]), "1 bytes too many"),
        (bytes([0x60, 9]), "cut off or damaged"),
        (bytes([0x41, 0]), "marks are cut off"),
        (bytes([0x44, 2]) + bytes([0, 1, 2, 3, 4, 5]) * 2, "out of order"),
        (bytes([0x42, 1, 0, 0, 0, 0, 0, 0, 1, 2, 99]), "notes are cut off"),
        (bytes([0x42, 99, 3, 0, 0, 0, 0]), "notes are"),
        (bytes([0x40]) + bytes(70_000), "at most 65536 bytes"),
    ],
)
def test_damaged_memories_are_refused(data, message):
    with pytest.raises(TagMemoryError, match=message):
        decode_memory(data)
    with pytest.raises(TagMemoryError):
        merge_bytes(encode_memory(TagMemory.empty()), data)


def test_a_new_note_is_the_newest_and_is_cut_to_what_a_tag_takes():
    old = Notes((Note(4, "Ada", "up"),)).fit(16)
    note = note_of("K" * 40, "é" * 100, old)
    assert (note.number, note.author, len(note.text)) == (5, "K" * 16, 60)
    assert note_of("Kim", "x", Notes()).number == 1
    kept = old.merge(Notes((note,))).fit(16)
    assert note_of("Kim", "x", kept).number == 6
    with pytest.raises(ValueError, match="at most"):
        encode_memory(replace(TagMemory.empty(), notes=Notes((Note(1, "Kim", "x" * 121),))))


def test_equal_memories_are_equal_and_hash_alike():
    a, b = TagMemory(np.zeros((1, 1), np.uint8)), TagMemory(np.zeros((9, 9), np.uint8))
    assert a == b  # rings that say nothing do not count
    assert hash(a) == hash(b)
    b.cells[3, 4] = OPEN
    assert a != b
    assert a != "no memory"


def test_rows_go_north_and_columns_west():
    cells_seen = seen_round(grid_of(known_block(3.0, -2.0, 6.0, 1.0)), 0.5, 0.5)
    # metres north (x) and west (y) of the tag's own cell
    seen = {(int(i) - MIDDLE, int(j) - MIDDLE) for i, j in np.argwhere(cells_seen != UNSEEN)}
    assert seen == {(north, west) for north in (3, 4, 5) for west in (-2, -1, 0)}


def test_cells_at_the_edge_of_the_known_are_open_and_inside_it_closed():
    cells_seen = seen_round(grid_of(known_block(-3.0, -3.0, 4.0, 4.0)), 0.5, 0.5)
    window = cells_seen[MIDDLE - 3 : MIDDLE + 4, MIDDLE - 3 : MIDDLE + 4]
    np.testing.assert_array_equal(window[1:-1, 1:-1], CLOSED)
    for rim in (window[0], window[-1], window[:, 0], window[:, -1]):
        np.testing.assert_array_equal(rim, OPEN)


def test_walls_close_the_ground_behind_them():
    cells = known_block(-3.0, -3.0, 4.0, 4.0)
    cells[170, 170:240] = cells[239, 170:240] = OCCUPIED
    cells[170:240, 170] = cells[170:240, 239] = OCCUPIED
    cells_seen = seen_round(grid_of(cells), 0.5, 0.5)
    np.testing.assert_array_equal(cells_seen[MIDDLE - 3 : MIDDLE + 4, MIDDLE - 3 : MIDDLE + 4], CLOSED)


@pytest.mark.parametrize(("width", "state"), [(0.2, UNSEEN), (0.3, CLOSED)])
def test_a_cell_counts_when_some_of_it_is_known(width, state):
    cells_seen = seen_round(grid_of(known_block(0.0, 0.0, width, 1.0, OCCUPIED)), 0.5, 0.5)
    assert cells_seen[MIDDLE, MIDDLE] == state


def test_ground_outside_the_window_or_the_map_is_left_out():
    cells = np.full((60, 60), FREE, np.uint8)  # 6 m by 6 m, all known
    cells_seen = seen_round(grid_of(cells, (-3.0, -3.0)), 0.5, 0.5)
    assert (cells_seen == CLOSED).sum() == 36
    assert not observed_memory(grid_of(cells, (90.0, 0.0)), 0.5, 0.5).cells.any()


def test_two_visits_from_two_sides_know_what_either_knows():
    north = observed_memory(grid_of(known_block(1.0, -3.0, 5.0, 3.0)), 0.5, 0.5)
    south = observed_memory(grid_of(known_block(-5.0, -3.0, 1.0, 3.0)), 0.5, 0.5)
    both = north.merge(south)
    assert (both.cells != UNSEEN).sum() == (north.cells != UNSEEN).sum() + (south.cells != UNSEEN).sum()
