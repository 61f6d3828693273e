"""What other tags said goes on to the next: cell by cell where it was, and never more than was said."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.exploration.told.claims import KnownTag
from robots.exploration.told.hearsay import Hearsay
from robots.tags.memory import CENTRED, CLOSED, OPEN, TagMemory, centred_phase, phase_of


def known(name: str, place: tuple[float, float], cells: np.ndarray, phase: int = CENTRED) -> KnownTag:
    return KnownTag(name, place, TagMemory(cells.astype(np.uint8), phase=phase), 0.0)


def cells_of(memory: TagMemory, place: tuple[float, float]) -> dict[tuple[float, float], int]:
    """States by the middles of cells in the map frame."""
    half = memory.side // 2
    return {
        (
            round(place[0] + memory.shift_m[0] + row - half, 1),
            round(place[1] + memory.shift_m[1] + column - half, 1),
        ): int(memory.cells[row, column])
        for row, column in np.argwhere(memory.cells)
    }


def test_nobody_said_anything():
    assert Hearsay().about((1.0, 2.0), CENTRED) == TagMemory.empty()


def test_what_tags_said_is_told_where_it_was_by_the_greatest_state():
    hearsay = Hearsay()
    first, second = np.zeros((3, 3)), np.zeros((5, 5))
    first[1, 2], second[2, 0], second[0, 0] = OPEN, CLOSED, OPEN
    tags = [known("A", (0.0, 0.0), first), known("B", (0.0, 3.0), second)]
    hearsay.draw(tags)
    wanted = {(0.0, 1.0): CLOSED, (-2.0, 1.0): OPEN}
    for place in ((0.0, 0.0), (7.0, -4.0), (-30.0, 12.0), (31.0, 0.0)):
        assert cells_of(hearsay.about(place, CENTRED), place) == {
            at: state
            for at, state in wanted.items()
            if max(abs(at[0] - place[0]), abs(at[1] - place[1])) <= 31
        }


@given(
    places=st.lists(
        st.tuples(st.integers(-40, 40), st.integers(-40, 40)), min_size=1, max_size=5, unique=True
    ),
    seed=st.integers(0, 1000),
    corner=st.tuples(st.integers(0, 15), st.integers(0, 15)),
)
def test_told_on_and_heard_again_it_says_no_more(places, seed, corner):
    """Tags that tell each other all they heard come to rest, whatever their order."""
    rng = np.random.default_rng(seed)
    lattice = corner[0] / 16.0, corner[1] / 16.0
    tags = [
        known(f"T{k}", at, rng.integers(0, 3, (7, 7)), phase_of(*at, lattice)) for k, at in enumerate(places)
    ]
    first, again = Hearsay(), Hearsay()
    first.draw(tags)
    told = [
        KnownTag(tag.tag_id, tag.place_m, tag.memory.merge(first.about(tag.place_m, tag.memory.phase)), 1.0)
        for tag in tags
    ]
    again.draw(tags[::-1])
    again.draw(told)
    for tag in tags:
        phase = tag.memory.phase
        assert again.about(tag.place_m, phase) == first.about(tag.place_m, phase)


def test_cells_of_another_size_are_not_told_on():
    hearsay, cells = Hearsay(), np.full((3, 3), CLOSED)
    coarse = centred_phase(2.0)
    hearsay.draw([known("A", (0.0, 0.0), cells), known("B", (9.0, 0.0), cells, coarse)])
    assert len(cells_of(hearsay.about((0.0, 0.0), CENTRED), (0.0, 0.0))) == 9
    assert hearsay.about((0.0, 0.0), coarse) == TagMemory.empty()
