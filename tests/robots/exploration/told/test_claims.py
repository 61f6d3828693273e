"""What tags say of the ground is drawn where they lie, and counts where nothing is known."""

from math import ceil

import numpy as np
import pytest

from robots.exploration.told.claims import Claims
from robots.exploration.told.survey import LATTICE_M
from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.tags.marks import VictimMark, goal_mark, key_of
from robots.tags.memory import CLOSED, OPEN, UNSEEN, TagMemory

ORIGIN = (-10.0, -10.0)


def grid(known=None) -> PlanGrid:
    """A map of 20 m by 20 m; ``known`` (x0, y0, x1, y1) is free."""
    cells = np.full((200, 200), UNKNOWN, np.uint8)
    if known is not None:
        x0, y0, x1, y1 = (round((value + 10.0) * 10) for value in known)
        cells[y0:y1, x0:x1] = FREE
    return PlanGrid(cells, np.zeros_like(cells), ORIGIN, 0.1)


def window(*cells, side=5) -> TagMemory:
    """A memory with cells (north, west, state) from the tag."""
    found = np.zeros((side, side), np.uint8)
    for north, west, state in cells:
        found[side // 2 + north, side // 2 + west] = state
    return TagMemory(found)


def drawn(survey) -> dict[tuple[float, float], int]:
    """Lower left corners of the lattice's claimed cells, with their states."""
    rows, columns = np.nonzero(survey.claimed)
    return {
        (ORIGIN[0] + c * LATTICE_M, ORIGIN[1] + r * LATTICE_M): int(survey.claimed[r, c])
        for r, c in zip(rows, columns, strict=True)
    }


def test_a_window_is_drawn_round_its_tag_north_along_x():
    claims = Claims()
    claims.hear("A", window((2, 0, CLOSED), (0, 1, OPEN)))
    survey = claims.survey(grid(), claims.tags({"A": (1.5, 2.5)}.get))
    assert drawn(survey) == {
        **{(3.0 + dx, 2.0 + dy): CLOSED for dx in (0.0, 0.5) for dy in (0.0, 0.5)},
        **{(1.0 + dx, 3.0 + dy): OPEN for dx in (0.0, 0.5) for dy in (0.0, 0.5)},
    }


def test_it_moves_with_the_tag_and_waits_while_nobody_knows_where_that_is():
    claims = Claims()
    claims.hear("A", window((0, 0, CLOSED), side=1))
    assert drawn(claims.survey(grid(), claims.tags({}.get))) == {}
    for x, y in ((0.5, 0.5), (4.5, -3.5), (9.9, 9.9), (30.0, 0.0), (-10.2, 0.5)):
        places = drawn(claims.survey(grid(), claims.tags({"A": (x, y)}.get)))
        assert all(abs(px + 0.25 - x) <= 1.0 and abs(py + 0.25 - y) <= 1.0 for px, py in places)
        assert len(places) == {0.5: 4, 4.5: 4, 9.9: 1, 30.0: 0, -10.2: 2}[x]


def test_tags_add_up_and_read_again_they_say_no_less():
    claims = Claims()
    claims.hear("A", window((0, 0, OPEN), (1, 0, CLOSED)))
    claims.hear("A", window((0, 0, CLOSED)))
    claims.hear("B", window((0, 0, CLOSED)))
    survey = claims.survey(grid(), claims.tags({"A": (0.5, 0.5), "B": (0.5, 0.5)}.get))
    assert set(drawn(survey).values()) == {CLOSED}
    assert len(drawn(survey)) == 8
    assert UNSEEN not in drawn(survey).values()


def test_shares_speak_of_unknown_ground_alone_and_all_is_unknown_beyond_the_map():
    claims = Claims()
    claims.hear("A", TagMemory(np.full((31, 31), CLOSED, np.uint8)))
    survey = claims.survey(grid((-10.0, -10.0, 0.0, 10.0)), claims.tags({"A": (0.25, 0.25)}.get))
    points = np.array([(-5.0, 0.0), (5.0, 0.0), (0.0, 0.0), (100.0, 0.0)])
    untold, claimed = survey.shares(points, 3.0)
    np.testing.assert_allclose(untold, [0.0, 0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(claimed, [0.0, 1.0, 7 / 13, 0.0], atol=1e-9)


@pytest.mark.parametrize("point", [(0.0, 0.0), (9.9, 9.9), (-10.0, 3.0), (55.0, -80.0)])
def test_shares_add_up_to_what_is_unknown(point):
    rng = np.random.default_rng(3)
    claims = Claims()
    claims.hear("A", TagMemory(rng.integers(0, 3, (31, 31)).astype(np.uint8)))
    cells = rng.integers(0, 3, (200, 200)).astype(np.uint8)
    survey = claims.survey(
        PlanGrid(cells, np.zeros_like(cells), ORIGIN, 0.1), claims.tags({"A": (1.0, 1.0)}.get)
    )
    untold, claimed = survey.shares(np.array([point]), 3.0)
    row, column = (int((v + 10.0) // LATTICE_M) for v in point[::-1])
    around = [(r, c) for r in range(row - 6, row + 7) for c in range(column - 6, column + 7)]
    unknown = [survey.unknown[r, c] if 0 <= r < 40 and 0 <= c < 40 else 1.0 for r, c in around]
    assert untold[0] + claimed[0] == pytest.approx(np.mean(unknown))


@pytest.mark.parametrize("cell_m", [0.1, 0.2, 0.25])
def test_the_unknown_share_is_that_of_the_plan_cells_whose_centres_lie_there(cell_m):
    rng = np.random.default_rng(1)
    cells = rng.choice([UNKNOWN, FREE], (37, 52)).astype(np.uint8)
    grid = PlanGrid(cells, np.zeros_like(cells), ORIGIN, cell_m)
    unknown = Claims().survey(grid, ()).unknown
    assert unknown.shape == (ceil(37 * cell_m / LATTICE_M - 1e-6), ceil(52 * cell_m / LATTICE_M - 1e-6))
    n = 200  # beyond the grid all is unknown
    beyond = np.full((n, n), UNKNOWN, np.uint8)
    beyond[:37, :52] = cells
    at = ((np.arange(n) + 0.5) * cell_m / LATTICE_M).astype(int)
    for r in range(unknown.shape[0]):
        for c in range(unknown.shape[1]):
            block = beyond[np.ix_(at == r, at == c)]
            assert unknown[r, c] == pytest.approx((block == UNKNOWN).mean())


def test_what_lies_within_the_error_of_a_tags_place_is_doubtful():
    claims = Claims()
    claims.hear("A", TagMemory(np.full((5, 5), CLOSED, np.uint8)))
    sure = claims.survey(grid(), claims.tags({"A": (0.5, 0.5)}.get))
    assert not sure.doubtful.any()
    claims.hear("A", TagMemory.empty(), 1.0, sd_m=0.3)  # read again where the robot knows less where it is
    vague = claims.survey(grid(), claims.tags({"A": (0.5, 0.5)}.get))
    assert ((vague.claimed == CLOSED) | vague.doubtful == (sure.claimed == CLOSED)).all()
    assert (vague.claimed == CLOSED).sum() == 6 * 6
    assert (sure.claimed == CLOSED).sum() == 10 * 10
    np.testing.assert_array_less(vague.shares(np.array([(0.5, 0.5)]), 3.0)[1], 1.0)


def test_where_others_went_is_told_and_not_where_this_robot_went():
    claims = Claims()
    claims.own = key_of("me")
    passes = (
        goal_mark("other", 1, 0, 3.0, -2.0),
        goal_mark("me", 1, 0, 9.0, 9.0),
        goal_mark("idle", 1, 0, 0, 0),
    )
    claims.hear("A", TagMemory(np.zeros((1, 1), np.uint8), passes=passes))
    promised = claims.survey(grid(), claims.tags({"A": (1.0, 1.0)}.get)).promised
    np.testing.assert_allclose(promised, [(4.0, -1.0)])


def test_only_a_victim_that_a_tag_is_sure_of_is_known():
    marks = (VictimMark(51, 3, 10, 0, 1), VictimMark(204, 3, 0, 20, 2))
    claims = Claims()
    claims.hear("A", TagMemory(np.zeros((1, 1), np.uint8), victims=marks))
    (sure,) = claims.victims({"A": (1.0, 1.0)}.get)
    assert (sure.x, sure.y) == (1.0, 3.0)
