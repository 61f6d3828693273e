"""What a robot leaves in tags: own ground and ways, how often it passed, where it went."""

import numpy as np
import pytest

from robots.exploration.told.claims import Claims
from robots.exploration.told.witness import Witness
from robots.planning.plan_grid import FREE, OCCUPIED, UNKNOWN, PlanGrid
from robots.tags.content import decode_memory, encode_memory
from robots.tags.marks import key_of
from robots.tags.memory import CENTRED, CLOSED, OPEN, UNSEEN, TagMemory, phase_of
from robots.tags.observed import observed_memory

GRID = PlanGrid(np.full((100, 100), FREE, np.uint8), np.zeros((100, 100), np.uint8), (-5.0, -5.0), 0.1)
TRAIL = np.array([(0.0, 0.0, 0.0, 0.0), (0.3, 0.0, 0.0, 1.0), (0.8, 0.0, 0.0, 2.0)])


def about(witness, place=(0.0, 0.0), said=None, goal=(3.0, -2.0), now_s=0.0, tag_id="A"):
    said = said or TagMemory.empty()
    return witness.about(tag_id, place, said, GRID, TRAIL, goal, now_s)


def test_it_tells_of_ground_ways_and_goal():
    told = about(Witness("r1", 0.5))
    assert (told.cells == CLOSED).sum() > 60
    assert told.visited.sum() == 3
    (passage,) = told.passes
    assert (passage.key, passage.count, passage.goal_m) == (key_of("r1"), 1, (3.0, -2.0))


def test_a_passage_counts_once_however_long_it_is_read_and_the_last_goal_counts():
    witness = Witness("r1", 0.5)
    seen = [about(witness, now_s=0.5 * k, goal=(3.0 + 0.1 * k, 0.0)).passes[0] for k in range(60)]
    assert {p.count for p in seen} == {1}
    assert max(seen).goal_m is not None
    assert max(seen).goal_m[0] > 6.0
    assert about(witness, now_s=60.0).passes[0].count == 2
    assert about(witness, now_s=60.0, tag_id="B").passes[0].count == 1
    assert max(seen) < about(witness, now_s=90.0, goal=None).passes[0]


def test_new_tags_get_the_lattice_of_the_first_that_told():
    corner = (0.25, 0.75)
    witness = Witness("r1", 0.5)
    said = observed_memory(GRID, 0.0, 0.0, phase_of(0.0, 0.0, corner))
    assert about(witness, said=said).phase == said.phase
    assert about(witness, place=(1.5, 0.5), tag_id="B").phase == phase_of(1.5, 0.5, corner)
    assert about(Witness("r2", 0.5), place=(1.5, 0.5)).phase == CENTRED
    foreign = observed_memory(GRID, 2.0, 0.0, 17)
    assert about(witness, place=(2.0, 0.0), said=foreign).phase == 17


def test_what_was_called_open_is_closed_once_its_edge_is_gone():
    """A cell over the outer wall: a frontier while its strip of free ground was new, then hardly known."""
    cells = np.full((100, 100), UNKNOWN, np.uint8)
    cells[:, :51] = FREE
    cells[:, 51] = OCCUPIED
    grid = PlanGrid(cells, np.zeros_like(cells), (-5.0, -5.0), 0.1)
    strip = np.zeros((3, 3), np.uint8)
    strip[2, 1] = OPEN  # x 0.5 to 1.5, of which nothing is known
    touched = np.zeros((3, 3), np.uint8)
    touched[1, 1] = OPEN
    for said, state in ((TagMemory.empty(), UNSEEN), (TagMemory(touched), CLOSED)):
        told = Witness("r1", 0.5).about("A", (0.45, 0.0), said, grid, TRAIL, None, 0.0)
        assert told.cells[len(told.cells) // 2, len(told.cells) // 2] == state
    told = Witness("r1", 0.5).about("A", (0.0, 0.0), TagMemory(strip), grid, TRAIL, None, 0.0)
    assert told.cells[len(told.cells) // 2 + 1, len(told.cells) // 2] == UNSEEN


@pytest.mark.parametrize("cell_m", [0.5, 1.0, 2.0])
def test_cells_of_any_size_tell_of_the_same_ground(cell_m):
    witness = Witness("r1", 0.5, cell_m)
    told = about(witness, place=(0.3, -0.6))
    assert told.cell_m == cell_m
    assert (told.cells == CLOSED).sum() * cell_m**2 == pytest.approx(100.0, abs=44.0)  # half a ring of 2 m
    assert decode_memory(encode_memory(told)) == told
    claims = Claims()
    claims.hear("A", told)
    unknown = PlanGrid(
        np.full((300, 300), UNKNOWN, np.uint8), np.zeros((300, 300), np.uint8), (-15, -15), 0.1
    )
    rows, columns = np.nonzero(claims.survey(unknown, claims.tags({"A": (0.3, -0.6)}.get)).claimed)
    edges = [(np.min(k) * 0.5 - 15.0, (np.max(k) + 1) * 0.5 - 15.0) for k in (rows, columns)]
    np.testing.assert_allclose(edges, [(-5.0, 5.0)] * 2, atol=cell_m)


def test_who_finds_cells_of_another_size_goes_on_with_them():
    found = about(Witness("r1", 0.5, 2.0), place=(1.0, 1.0))
    witness = Witness("r2", 0.5, 0.5)
    answer = about(witness, place=(1.0, 1.0), said=found)
    assert (answer.phase, found.merge(answer).cell_m) == (found.phase, 2.0)
    new = about(witness, place=(4.0, 1.5), tag_id="B")
    assert new.cell_m == 2.0
    apart = np.array((4.0, 1.5)) + new.shift_m - np.array((1.0, 1.0)) - found.shift_m
    np.testing.assert_allclose(apart % 2.0 % 2.0, 0.0, atol=1e-9)
