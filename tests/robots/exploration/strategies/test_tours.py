"""Tours through free ground, held against all ways there are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.exploration.strategies.tours.beam import best_way
from robots.exploration.strategies.tours.stations import NEW, stations_of
from robots.planning.travel import travel_costs
from robots.se2 import Pose2
from tests.robots.exploration.strategies.halls import (
    COARSE_M,
    FADES_M,
    REACH_M,
    hall,
)


def graph(draw_ways, stations, seen):
    """Stations 0 to n - 1, the last the start, joined both ways; each with its list of cells."""
    ends, ways = np.full((stations, 8), -1, np.int32), np.zeros((stations, 8))
    used = [0] * stations
    for (a, b), way in draw_ways.items():
        if a == b or max(used[a], used[b]) == 8:
            continue
        for here, there in ((a, b), (b, a)):
            ends[here, used[here]], ways[here, used[here]] = there, way
            used[here] += 1
    first = np.concatenate([[0], np.cumsum([len(cells) for cells in seen])]).astype(np.int64)
    return ends, ways, first, np.array([c for cells in seen for c in cells], np.int32)


def gain_of(way, lengths, seen, worth):
    """What a way gains, counted by hand: each cell once, when it is first in sight."""
    done, gain = set(seen[way[0]]), 0.0
    for station, length in zip(way[1:], lengths[1:], strict=True):
        fresh = set(seen[station]) - done
        gain += sum(worth[cell] for cell in fresh) * max(0.0, 1.0 - length / FADES_M)
        done |= fresh
    return gain


def places_of(count):
    return np.random.default_rng(7).uniform(-1.0, 1.0, (count, 2))


def goes_on(three):
    return float(np.diff(three, axis=0)[0] @ np.diff(three, axis=0)[1]) >= -0.1


def all_ways(places, ends, ways, longest, way, lengths):
    yield way, lengths
    for to, metres in zip(ends[way[-1]], ways[way[-1]], strict=True):
        far = lengths[-1] + metres
        if to >= 0 and far < longest + 1 and (len(way) < 2 or goes_on(places[[*way[-2:], to]])):
            yield from all_ways(places, ends, ways, longest, [*way, int(to)], [*lengths, far])


@st.composite
def graphs(draw):
    count = draw(st.integers(1, 5))
    node = st.integers(0, count - 1)
    joins = draw(
        st.dictionaries(
            st.tuples(node, node).map(lambda p: (min(p), max(p))), st.floats(1.0, 2.9), max_size=7
        )
    )
    seen = draw(
        st.lists(st.lists(st.integers(0, 69), unique=True, max_size=6), min_size=count, max_size=count)
    )
    worth = draw(st.lists(st.floats(0.0, 1.0), min_size=70, max_size=70))
    return joins, count, seen, np.array(worth)


@settings(max_examples=25, deadline=None)
@given(graphs())
def test_where_all_ways_are_kept_none_gains_more(drawn):
    joins, count, seen, worth = drawn
    ends, ways, first, cells = graph(joins, count, seen)
    places = places_of(count)
    longest = 4
    way, gains, lengths = best_way(places, ends, ways, first, cells, worth, longest, 400, 400, FADES_M)
    most = max(
        gain_of(other, far, seen, worth)
        for other, far in all_ways(places, ends, ways, longest, [count - 1], [0.0])
    )
    assert gains[-1] == pytest.approx(most, abs=1e-6)
    assert gains[-1] == pytest.approx(gain_of(way.tolist(), lengths, seen, worth), abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(graphs(), st.integers(1, 6), st.integers(1, 2))
def test_a_way_of_a_narrow_beam_is_one_that_there_is_and_gains_what_it_says(drawn, width, per_station):
    joins, count, seen, worth = drawn
    ends, ways, first, cells = graph(joins, count, seen)
    places = places_of(count)
    way, gains, lengths = best_way(places, ends, ways, first, cells, worth, 20, width, per_station, FADES_M)
    assert way[0] == count - 1
    assert lengths[-1] < 21
    for here, there, metres in zip(way, way[1:], np.diff(lengths), strict=False):
        assert any(
            e == there and w == pytest.approx(metres) for e, w in zip(ends[here], ways[here], strict=True)
        )
    assert gains[-1] == pytest.approx(gain_of(way.tolist(), lengths, seen, worth), abs=1e-9)
    again = best_way(places, ends, ways, first, cells, worth, 20, width, per_station, FADES_M)
    assert all(a.tobytes() == b.tobytes() for a, b in zip((way, gains, lengths), again, strict=True))


def test_stations_stand_where_the_robot_gets_and_are_joined_where_it_can_drive_straight():
    grid = hall((np.s_[:, 60:62],))
    costs = travel_costs(grid, *grid.cell_of(3.1, 3.1))
    kinds = np.full((30, 50), NEW, np.uint8)
    stations = stations_of(grid, costs, Pose2(3.1, 3.1), kinds, COARSE_M, REACH_M)
    there = ~np.isnan(stations.places[:, 0])
    assert (stations.places[there, 0] < 12.0).all()
    assert there.sum() > 100
    for here in np.flatnonzero(there):
        for to, way_m in zip(stations.ends[here], stations.ways_m[here], strict=True):
            if to >= 0:
                assert way_m == pytest.approx(np.hypot(*(stations.places[here] - stations.places[to])))
    assert (stations.ends[-1] >= 0).any()
