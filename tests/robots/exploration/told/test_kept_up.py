"""What is kept up to date piece by piece is what it would be if it were made anew."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.exploration.told.atlas import Atlas
from robots.exploration.told.claims import Claims, KnownTag
from robots.exploration.told.tag_ways import TagWays
from robots.planning.plan_grid import FREE, OCCUPIED, PlanGrid
from robots.tags.memory import TagMemory

places = st.tuples(st.integers(-40, 40), st.integers(-40, 40)).map(lambda at: (at[0] / 4.0, at[1] / 4.0))
memories = st.integers(0, 10**6).map(
    lambda seed: TagMemory(np.random.default_rng(seed).integers(0, 3, (7, 7), np.uint8))
)
reads = st.lists(st.tuples(st.sampled_from("ABC"), places, memories), min_size=1, max_size=8)


def window(place, seed=0) -> PlanGrid:
    cells = np.random.default_rng(seed).choice(np.array([0, FREE, OCCUPIED], np.uint8), (20, 20))
    return PlanGrid(cells, np.zeros_like(cells), place, 0.1)


@settings(deadline=None)
@given(reads=reads, looks=st.lists(places, max_size=4))
def test_an_atlas_drawn_step_by_step_is_one_drawn_at_once(reads, looks):
    kept, anew, last = Atlas(), Atlas(), {}
    for k, (name, _, memory) in enumerate(reads):
        tag = KnownTag(name, (float(ord(name) - 64), 0.5), memory, 0.0)
        kept.draw([tag])
        anew.draw([tag])
        if k < len(looks):
            kept.see(window(looks[k], k))
            anew.see(window(looks[k], k))
        kept.settle()
        last[name] = tag
    anew._note(*anew.corner, *anew._told.shape)
    anew.settle()
    assert kept.corner == anew.corner
    np.testing.assert_array_equal(kept.cells, anew.cells)
    grid = window((-3.0, -3.0), 99)
    np.testing.assert_array_equal(kept.with_covered(grid), anew.with_covered(grid))
    points = np.array([[0.3, 0.7], [-2.0, 4.0], [30.0, 1.0]])
    whole = Atlas.survey(kept, np.array([[-500.0, -500.0], [500.0, 500.0]]), 2.0)
    assert whole.claimed.shape == kept.cells.shape
    for a, b in zip(kept.survey(points, 2.0).shares(points, 2.0), whole.shares(points, 2.0), strict=True):
        np.testing.assert_array_equal(a, b)


@settings(deadline=None)
@given(reads=reads, sd_m=st.sampled_from([0.0, 0.3]))
def test_claims_asked_after_every_word_say_what_they_say_asked_once(reads, sd_m):
    asked, once, where = Claims(), Claims(), {}
    grid = window((-1.0, -1.0))
    for name, place, memory in reads:
        where[name] = place
        for claims in (asked, once):
            claims.hear(name, memory, 0.0, sd_m)
        asked.survey(grid, asked.tags(where.get))
    kept, anew = (claims.survey(grid, claims.tags(where.get)) for claims in (asked, once))
    for part in ("claimed", "doubtful", "shade", "unknown", "promised"):
        np.testing.assert_array_equal(getattr(kept, part), getattr(anew, part))
    for a, b in zip(asked.tags(where.get), once.tags(where.get), strict=True):
        assert (a.tag_id, a.place_m) == (b.tag_id, b.place_m)
        assert a.memory == b.memory


def test_ways_along_many_tags_are_the_shortest():
    """Against every way over three links, among tags that the robot saw from many places."""
    random, ways = np.random.default_rng(3), TagWays()
    at = [tuple(place) for place in random.uniform(0.0, 12.0, (60, 2)).tolist()]
    for k, place in enumerate(at):
        ways.note(f"T{k}", place)
    links = np.full((60, 60), np.inf)
    for x, y in random.uniform(0.0, 10.0, (40, 2)).tolist():
        grid = PlanGrid(np.full((40, 40), FREE, np.uint8), np.zeros((40, 40), np.uint8), (x, y), 0.1)
        costs = (np.hypot(*(np.indices((40, 40)) - 20)) * 5).astype(np.int32)
        reached = ways.see((x + 2.0, y + 2.0), grid, costs)
        near = np.argsort(reached, kind="stable")[: min(6, np.isfinite(reached).sum())]
        for a in near:
            for b in near:
                if a != b and reached[a] + reached[b] <= 5.0:
                    links[a, b] = min(links[a, b], reached[a] + reached[b])
    first = np.full(60, np.inf)
    first[0] = 0.0
    expected = first.copy()
    for _ in range(60):
        expected = np.minimum(expected, (expected[:, None] + links).min(axis=0))
    found, before = ways.ways(first)
    np.testing.assert_allclose(found, expected)
    assert np.isfinite(found).sum() > 20
    for k in np.flatnonzero((before >= 0) & np.isfinite(found)):
        assert found[k] == pytest.approx(found[before[k]] + links[before[k], k])
