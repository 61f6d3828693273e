"""Routes: the shortest of all, along what was driven, in words that lead there."""

import itertools
from math import hypot, inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.routes.hazards import Hazard, is_near
from robots.routes.planner import NoRouteError, RouteMap
from robots.routes.sight import is_clear
from robots.routes.ways import Way, length, shortest_ways, simplified, way_walked, ways_along
from robots.routes.words import OF_PLAN, North, bearing_deg, is_narrow, is_uncertain, last_text, leg_text
from robots.team import TeamGrid

TRUE = North(0.0)  # the plan's x axis points north

names = st.sampled_from("ABCDEFG")
places = {name: (float(3 * k % 7), float(5 * k % 11)) for k, name in enumerate("ABCDEFG")}


def straight(a: str, b: str) -> Way:
    """A way; some are narrow."""
    narrow_cm = 400 * ((ord(a) + ord(b)) % 3)
    return Way(a, b, np.array([places[a], places[b]]), 0.6 if narrow_cm else inf, narrow_cm)


@given(st.lists(st.tuples(names, names).filter(lambda p: p[0] != p[1]), max_size=12), names, names)
def test_a_route_is_as_short_as_the_best_of_all_walks(pairs, start, goal):
    ways = shortest_ways(straight(a, b) for a, b in pairs)
    cost = dict.fromkeys(itertools.product(places, places), inf)
    cost |= {(a, a): 0.0 for a in places} | {key: way.cost_cm for key, way in ways.items()}
    for k, a, b in itertools.product(places, places, places):  # Floyd 1962
        cost[a, b] = min(cost[a, b], cost[a, k] + cost[k, b])
    roads = RouteMap(straight(a, b) for a, b in pairs)
    if cost[start, goal] == inf:
        with pytest.raises(NoRouteError, match=f"tag {start}"):
            roads.route(start, [goal])
        return
    legs = roads.route(start, [goal])
    assert sum(leg.way.cost_cm for leg in legs) == cost[start, goal]
    tags = [start, *(leg.way.to_tag for leg in legs)]
    assert tags[-1] == goal
    assert all(leg.way.from_tag == tag for leg, tag in zip(legs, tags, strict=False))


@given(st.lists(st.tuples(names, names).filter(lambda p: p[0] != p[1]), max_size=12), names, names, names)
def test_of_several_ends_the_one_that_is_nearest_in_all_is_taken(pairs, start, one, other):
    roads = RouteMap(straight(a, b) for a, b in pairs)
    ends = {one: 2.0, other: 5.0}

    def whole(goals):
        try:
            legs = roads.route(start, goals, ends)
        except NoRouteError:
            return inf
        last = legs[-1].way.to_tag if legs else start
        return sum(leg.way.cost_cm for leg in legs) + 100.0 * ends[last]

    assert whole([one, other]) == pytest.approx(min(whole([one]), whole([other])))


@given(
    st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20)), min_size=2, max_size=30), st.floats(0.05, 3)
)
def test_a_simplified_line_stays_near_and_keeps_its_ends(points, within):
    line = np.array(points)
    found = simplified(line, within)
    assert (found[0] == line[0]).all()
    assert (found[-1] == line[-1]).all()
    assert length(found) <= length(line) + 1e-9
    for point in line:
        gaps = []
        for a, b in itertools.pairwise(found):
            share = np.clip((point - a) @ (b - a) / max((b - a) @ (b - a), 1e-12), 0, 1)
            gaps.append(hypot(*(point - a - share * (b - a))))
        assert min(gaps) <= within + 1e-6


def test_ways_follow_the_trail_from_tag_to_tag():
    trail = np.vstack([np.linspace((0, 0), (6, 0), 61), np.linspace((6, 0.1), (6, -4), 41)])
    ways = ways_along(trail, {"A": (0.0, 0.3), "B": (6.0, -4.0), "far": (20.0, 0.0)})
    (way,) = ways
    assert (way.from_tag, way.to_tag) == ("A", "B")
    assert way.length_m == pytest.approx(10.0, abs=0.5)
    assert len(way.points_m) == 3  # it bends once


def test_a_tag_passed_again_begins_a_way_again():
    there = np.linspace((0, 0), (4, 0), 41)
    ways = ways_along(np.vstack([there, there[::-1]]), {"A": (0.0, 0.0), "B": (4.0, 0.0)})
    assert [(way.from_tag, way.to_tag) for way in ways] == [("A", "B"), ("B", "A")]
    assert ways_along(there, {"A": (0.0, 0.0)}) == []


def test_words_say_how_far_which_way_and_where_to_turn():
    way = Way("A", "B", np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 3.0]]))
    (leg,) = RouteMap([way]).route("A", ["B"])
    assert leg_text(leg, "en", TRUE) == "Go 6 m north, turn left and go 3 m to tag B."
    assert leg_text(leg) == "Go 6 m plan north, turn left and go 3 m to tag B."
    assert leg_text(leg, "en", North(100.0)) == "Go 6 m east, turn left and go 3 m to tag B."
    (back,) = RouteMap([way]).route("B", ["A"])
    assert leg_text(back, "en", TRUE) == "Go 3 m east, turn right and go 6 m to tag A."
    (vague,) = RouteMap([way], {"A": 3.0}).route("A", ["B"])
    assert leg_text(vague, "en", TRUE) == "Go about 6 m north, turn left and go about 3 m to tag B."


def test_a_walk_is_as_long_as_the_steps_were_and_uncertain_and_a_guess_costs_more():
    at = {"A": (0.0, 0.0), "B": (6.0, 0.0), "far": (31.0, 0.0)}
    counted, guessed = way_walked("A", "B", at, 9.04), way_walked("A", "B", at, None)
    assert (counted.length_m, counted.cost_cm) == (9.04, 904)
    assert (guessed.length_m, guessed.cost_cm) == (6.0, 900)
    assert way_walked("A", "B", at, 3.0).cost_cm == 900  # not all steps were counted
    assert way_walked("A", "B", at, 5.0).length_m == 6.0  # a straight line is the shortest
    assert way_walked("A", "far", at, None) is None
    (leg,) = RouteMap([counted]).route("B", ["A"])
    assert is_uncertain(leg)
    assert (
        leg_text(leg, "en", TRUE)
        == "Go about 9 m south to tag A. Somebody walked it; just where is not known."
    )
    driven = Way("A", "B", np.array([[0.0, 0.0], [6.0, 0.0]]), narrow_cm=200)
    (leg,) = RouteMap([counted, guessed, driven]).route("A", ["B"])
    assert leg.way is driven
    assert not is_uncertain(leg)


def test_what_is_not_known_well_has_to_be_searched_for():
    way = Way("A", "victim:v1", np.array([[0.0, 0.0], [7.0, 0.0]]))
    assert last_text(way, "victim v1", 0.9, (), north=TRUE) == "From tag A go 7 m north: there is victim v1."
    words = last_text(way, "victim v1", 3.0, ("gas",), north=TRUE)
    there = "From tag A go about 7 m north and search there: victim v1 is within about 6 m."
    assert words == f"{there} Take care: gas."


@pytest.mark.parametrize(
    ("to", "bearing", "point"),
    [((1, 0), 0, "north"), ((0, -1), 90, "east"), ((-1, 0), 180, "south"), ((0, 1), 270, "west"),
     ((1, -1), 45, "north-east")],
)  # fmt: skip
def test_bearings_are_the_compass(to, bearing, point):
    found = bearing_deg(np.zeros(2), np.array(to, float))
    assert found == pytest.approx(bearing)
    assert TRUE.point(found) == point
    assert North(30.0).bearing_deg(np.zeros(2), np.array(to, float)) == pytest.approx((found + 30.0) % 360.0)
    assert TRUE.point(359.0) == "north"
    assert OF_PLAN.point(90.0, "de") == "Plan-Osten"


def test_hazards_are_gone_round_where_that_is_possible_and_told_where_not():
    direct = Way("A", "B", np.array([[0.0, 0.0], [10.0, 0.0]]))
    round_ = [
        Way("A", "C", np.array([[0.0, 0.0], [0.0, 9.0]])),
        Way("C", "B", np.array([[0.0, 9.0], [10.0, 9.0]])),
    ]
    gas = Hazard("gas", ((5.0, 1.0),))
    fire = Hazard("fire", ((4.0, -3.0), (6.0, -3.0), (6.0, 3.0), (4.0, 3.0)))
    for hazard in (gas, fire):
        legs = RouteMap([direct, *round_], hazards=[hazard]).route("A", ["B"])
        assert [leg.way.to_tag for leg in legs] == ["C", "B"]
        (leg,) = RouteMap([direct], hazards=[hazard]).route("A", ["B"])
        assert leg_text(leg).endswith(f"to tag B. Take care: {hazard.text}.")
    assert [leg.way.to_tag for leg in RouteMap([direct, *round_]).route("A", ["B"])] == ["B"]


points_near = st.tuples(st.integers(-900, 900), st.integers(-900, 900))


def test_a_way_along_the_side_of_an_area_is_near_it_however_far_its_corners_are():
    fire = Hazard("fire", ((-10.0, 0.0), (10.0, 0.0), (10.0, 20.0), (-10.0, 20.0)))
    for y, expected in ((-0.1, True), (-1.9, True), (-2.1, False), (10.0, True)):
        assert is_near(np.array([[-1.0, y], [1.0, y]]), fire) is expected
    assert is_near(np.array([[-30.0, 5.0], [30.0, 5.0]]), fire)  # right through, no point of it within
    assert is_near(np.array([[-30.0, 0.0], [30.0, 0.0]]), Hazard("gas", ((5.0, 1.9),)))
    assert not is_near(np.array([[-30.0, 0.0], [30.0, 0.0]]), Hazard("gas", ((5.0, 2.0),)))


@given(st.lists(points_near, min_size=2, max_size=4), st.lists(points_near, min_size=1, max_size=3))
def test_near_is_what_looking_every_five_centimetres_finds(line, corners):
    points, sides = np.array(line) / 100.0, np.array(corners) / 100.0

    def walked(path, step_m):
        return np.vstack(
            [np.linspace(a, b, 2 + int(hypot(*(b - a)) / step_m)) for a, b in itertools.pairwise(path)]
        )

    way, rim = walked(points, 0.05), walked(np.vstack([sides, sides[:1]]), 0.05)
    gap = np.hypot(*(way[:, None] - rim[None]).transpose(2, 0, 1)).min()
    within = len(sides) == 3 and any(abs(_turns(sides, point)) > 0.5 for point in way[::20])
    if within or not 2.0 <= gap < 2.06:
        assert is_near(points, Hazard("hole", tuple(map(tuple, sides.tolist())))) == (within or gap < 2.0)


def _turns(corners, point):
    """How often a polygon goes round a point."""
    angles = np.arctan2(*(corners - point).T[::-1])
    return ((np.roll(angles, -1) - angles + np.pi) % (2 * np.pi) - np.pi).sum() / (2 * np.pi)


def test_a_wall_hides_what_is_behind_it_but_not_what_lies_against_it():
    cells = np.zeros((60, 100), np.int8)
    cells[:50, 40:42] = 100  # a wall at x = 4 m that ends at y = 5 m
    grid = TeamGrid(cells, (0.0, 0.0), 0.1, 1)
    assert is_clear(grid, (1.0, 1.0), (3.0, 3.0))
    assert not is_clear(grid, (1.0, 1.0), (8.0, 1.0))
    assert is_clear(grid, (1.0, 5.5), (8.0, 5.5))
    assert is_clear(grid, (1.0, 1.0), (4.1, 1.0))  # against the wall
    assert is_clear(grid, (-9.0, 1.0), (1.0, 1.0))  # from beyond the map


def corridors(width_m: float) -> TeamGrid:
    """A block with a corridor round it: 2 m wide in the north, ``width_m`` in the south; cells of 5 cm."""
    cells = np.full((200, 300), 100, np.int8)
    cells[20:180, 20:280] = 0  # all round
    cells[60 if width_m >= 2.0 else 20 + round(20 * width_m) : 140, 60:240] = 100
    return TeamGrid(cells, (0.0, 0.0), 0.05, 1)


def ways_round(grid: TeamGrid, south_m: float) -> list[Way]:
    """Two ways from A to B: through the south, and through the north, which is longer."""
    tags = {"A": (2.0, 2.0), "B": (13.0, 2.0), "C": (7.5, 8.0)}
    y = 1.0 + south_m / 2.0
    south = [(2.0, 2.0), (2.0, y), (13.0, y), (13.0, 2.0)]
    north = [(2.0, 2.0), (2.0, 8.0), (7.5, 8.0), (13.0, 8.0), (13.0, 2.0)]
    trails = [np.vstack([np.linspace(a, b, 60) for a, b in itertools.pairwise(t)]) for t in (south, north)]
    return [way for trail in trails for way in ways_along(trail, tags, grid)]


def test_the_width_of_a_way_is_that_of_its_narrowest_passage():
    for width in (0.6, 0.9, 1.4):
        (south,) = [
            way for way in ways_round(corridors(width), width) if way.to_tag == "B" and way.from_tag == "A"
        ]
        assert south.width_m == pytest.approx(width, abs=0.11)
        assert is_narrow(south) == (width < 0.75)
    (wide,) = [way for way in ways_round(corridors(2.0), 2.0) if (way.from_tag, way.to_tag) == ("A", "B")]
    assert (wide.narrow_cm, is_narrow(wide)) == (0, False)
    assert wide.width_m > 1.8
    (unseen,) = ways_along(np.array([[2.0, 2.0], [13.0, 2.0]]), {"A": (2.0, 2.0), "B": (13.0, 2.0)})
    assert (unseen.width_m, unseen.narrow_cm) == (inf, 0)


def test_a_wide_passage_is_preferred_to_a_narrow_one_that_is_little_shorter():
    for width, through in ((0.6, ["C", "B"]), (1.4, ["B"])):
        legs = RouteMap(ways_round(corridors(width), width)).route("A", ["B"])
        assert [leg.way.to_tag for leg in legs] == through
    narrow = RouteMap([way for way in ways_round(corridors(0.6), 0.6) if way.to_tag == "B"]).route(
        "A", ["B"]
    )[0]
    assert leg_text(narrow).endswith("to tag B. Narrow: about 60 cm.") or "about 50 cm" in leg_text(narrow)
    assert "Eng: etwa" in leg_text(narrow, "de")
