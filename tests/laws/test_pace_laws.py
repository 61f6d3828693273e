"""Nobody who walks or runs is ever told that a tag cannot be where it is."""

from itertools import pairwise
from math import hypot

from hypothesis import given
from hypothesis import strategies as st

from robots.routes.pace import FASTEST_MPS, is_too_far

PLACES = st.tuples(st.floats(-200, 200), st.floats(-200, 200))
PACES = st.floats(0.1, FASTEST_MPS)
SDS = st.floats(0.0, 30.0)


@given(st.lists(PLACES, min_size=2, max_size=6), PACES, SDS, st.data())
def test_whoever_goes_any_way_on_foot_can_have_come(way, pace, sd_m, data):
    """Along any line, at any pace, on a map off by up to three deviations and on a phone that is slow."""
    walked_m = sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(way))
    straight_m = hypot(way[-1][0] - way[0][0], way[-1][1] - way[0][1])
    off_m = data.draw(st.floats(-3.0 * sd_m, 3.0 * sd_m))
    late_s = data.draw(st.floats(0.0, 1.9))
    after_s = max(0.0, walked_m / pace - late_s)
    assert not is_too_far(max(0.0, straight_m + off_m), sd_m, after_s)


@given(st.floats(0.0, 600.0), SDS, st.floats(0.1, 1e4))
def test_what_is_further_than_anybody_runs_is_told(after_s, sd_m, more_m):
    assert is_too_far(FASTEST_MPS * (after_s + 2.0) + 3.0 * sd_m + more_m, sd_m, after_s)


@given(st.floats(0.0, 1e6), SDS, st.floats(max_value=-1e-9, allow_infinity=False))
def test_a_clock_that_was_set_back_proves_nothing(straight_m, sd_m, after_s):
    assert not is_too_far(straight_m, sd_m, after_s)
