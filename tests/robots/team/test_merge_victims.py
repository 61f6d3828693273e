"""Victims are one where they cannot be told apart, and two where they can."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.codec import encode
from robots.team.types import TeamUpdate, TeamVictim
from robots.team.victims import merge_victims


def victim(name: str, x: float, y: float, sd: float, robot: str = "r1", kind: str = "person") -> TeamVictim:
    stamp = float(sum(map(ord, name)))
    return TeamVictim(name, x, y, np.eye(2) * sd**2, 0.6, 3, (robot,), stamp, stamp + 5.0, kind)


def test_two_seen_precisely_stay_two_and_one_seen_vaguely_is_one():
    precise = [victim("r1-V1", 0.0, 0.0, 0.12), victim("r2-V1", 1.0, 0.0, 0.12, "r2")]
    vague = [victim("r1-V1", 0.0, 0.0, 0.5), victim("r2-V1", 1.0, 0.0, 0.5, "r2")]
    assert len(merge_victims(precise)) == 2
    (one,) = merge_victims(vague)
    assert (one.x_m, one.robots, one.sightings) == (pytest.approx(0.5), ("r1", "r2"), 6)
    assert one.confidence == pytest.approx(0.84)


def test_robots_that_hardly_know_where_they_stand_to_each_other_see_the_same():
    precise = [victim("r1-V1", 0.0, 0.0, 0.12), victim("r2-V1", 1.0, 0.0, 0.12, "r2")]
    assert len(merge_victims(precise, lambda a, b: np.eye(2) * 0.4**2)) == 1
    assert len(merge_victims(precise, lambda a, b: np.eye(2) * 0.01**2)) == 2


def test_however_vague_what_is_far_apart_is_two_and_what_touches_is_one():
    assert len(merge_victims([victim("a", 0.0, 0.0, 5.0), victim("b", 3.5, 0.0, 5.0)])) == 2
    assert len(merge_victims([victim("a", 0.0, 0.0, 0.01), victim("b", 0.3, 0.0, 0.01)])) == 1


def test_of_unlike_kinds_nothing_is_merged():
    both = [victim("a", 0.0, 0.0, 0.5), victim("b", 0.1, 0.0, 0.5, kind="marker")]
    assert len(merge_victims(both)) == 2


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**9), st.integers(0, 4))
def test_the_order_does_not_matter(seed, count):
    rng = np.random.default_rng(seed)
    seen = [
        victim(f"r{k}-V1", *(float(v) for v in rng.uniform(0, 2, 2)), float(rng.uniform(0.1, 0.7)), f"r{k}")
        for k in range(count)
    ]
    outcomes = {
        encode(TeamUpdate((), (), (), merge_victims(list(order)), None, 0.0)) for order in permutations(seen)
    }
    assert len(outcomes) == 1
