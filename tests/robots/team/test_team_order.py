"""The team's map as a function of what was heard: not of the order, nor of what was shown on the way.

Played with a short mission of two robots, walls and all.
"""

from dataclasses import replace
from functools import lru_cache
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.agent import RobotAgent
from robots.codec import encode
from robots.mapping.fused import FusedGrid
from robots.mapping.submap import unpack
from robots.se2 import Pose2
from robots.sim.runner import run
from robots.sim.scenario import ScenarioConfig
from robots.team import StartPose, TeamMap, TeamRobot, TeamUpdate
from robots.types import AgentUpdate, Observation


def robot(update: TeamUpdate, name: str) -> TeamRobot:
    return next(robot for robot in update.robots if robot.robot_id == name)


News = tuple[tuple[str, AgentUpdate], ...]


@lru_cache(maxsize=1)
def played() -> tuple[News, dict[str, StartPose]]:
    heard: list[tuple[str, AgentUpdate]] = []

    class Telling(RobotAgent):
        def step(self, observation: Observation) -> AgentUpdate:
            update = super().step(observation)
            heard.append((self.robot_id, update))
            return update

    scenario = ScenarioConfig(map="office:100", robots=2, minutes=1.5, seed=5, victims=3)
    starts = {}
    for member in run(scenario, Telling).robots:
        heard.append((member.robot_id, member.report))
        starts[member.robot_id] = StartPose(member.start, 0.05, 0.02)
    return tuple(heard), starts


def mission() -> News:
    return played()[0]


def empty_team() -> TeamMap:
    team = TeamMap()
    for name, start in played()[1].items():
        team.add_robot(name, start)
    return team


def plain(update: TeamUpdate) -> bytes:
    """All but the grid's version, which counts how often it was published."""
    grid = None if update.grid is None else replace(update.grid, version=0)
    return encode(replace(update, grid=grid))


@lru_cache(maxsize=1)
def in_order() -> bytes:
    team = empty_team()
    for name, update in mission():
        team.put(name, update)
    return plain(team.solve())


def test_the_mission_is_worth_shuffling():
    team = empty_team()
    for name, update in mission():
        team.put(name, update)
    update = team.solve()
    assert [member.located for member in update.robots] == [True, True]
    assert len(update.tags) > 2
    assert update.grid is not None
    assert (update.grid.cells >= 65).sum() > 200
    assert update.explored_m2 > 20.0


slowly = settings(max_examples=12, deadline=None)


@slowly
@given(st.integers(0, 2**32))
def test_the_order_of_updates_and_how_often_they_come_do_not_matter(seed):
    random, updates = Random(seed), list(mission())
    updates += random.choices(updates, k=len(updates) // 4)
    random.shuffle(updates)
    team = empty_team()
    for name, update in updates:
        team.put(name, update)
    assert plain(team.solve()) == in_order()


@slowly
@given(st.integers(0, 2**32))
def test_what_was_lost_on_the_way_and_comes_later_leaves_no_trace(seed):
    """Half of the updates get through, the map is solved and shown on the way, then the rest arrives."""
    random, updates = Random(seed), list(mission())
    arrives = [random.random() < 0.5 for _ in updates]
    team = empty_team()
    shown = random.sample(range(len(updates)), 3)
    for k, (name, update) in enumerate(updates):
        if arrives[k]:
            team.put(name, update)
        if k in shown:
            team.solve()
    team.solve()
    missing = [item for item, came in zip(updates, arrives, strict=True) if not came]
    random.shuffle(missing)
    for name, update in missing:
        team.put(name, update)
    assert plain(team.solve()) == in_order()


def test_solving_twice_changes_nothing():
    team = empty_team()
    for name, update in mission():
        team.put(name, update)
    assert encode(team.solve()) == encode(team.solve())


def test_older_news_do_not_undo_newer():
    mine = [update for name, update in mission() if name == "r1"]
    team = TeamMap()
    team.add_robot("r1", None)
    team.put("r1", mine[-1])  # the report: everything
    whole = team.solve()
    for update in reversed(mine[:-1]):
        team.put("r1", update)
    again = team.solve()
    assert plain(replace(again, robots=())) == plain(replace(whole, robots=()))
    assert np.array_equal(robot(whole, "r1").anchors, robot(again, "r1").anchors)
    assert len(robot(again, "r1").trail_m) > len(robot(whole, "r1").trail_m)


def test_a_robot_that_turns_out_to_be_unjoined_leaves_the_map(journey):
    """r2 was heard first and was the world; then came r1, whose map the world is, and nothing joins them."""
    mine = [update for name, update in mission() if name == "r2"][-1:]
    other = journey("r1", [Pose2(), Pose2(2.0, 0.0, 0.0), Pose2(4.0, 1.0, 1.0)], {1: "X"})
    team = TeamMap()
    for name in ("r1", "r2"):
        team.add_robot(name, None)
    team.put("r2", mine[0])
    drawn = team.solve().grid
    assert drawn is not None
    assert (drawn.cells >= 65).any()
    for update in other:
        team.put("r1", update)
    update = team.solve()
    assert not robot(update, "r2").located
    fresh = TeamMap()
    for name, news in (("r1", other), ("r2", mine)):
        fresh.add_robot(name, None)
        for item in news:
            fresh.put(name, item)
    assert plain(update) == plain(fresh.solve())


def cells_at(cells: np.ndarray, origin_m: tuple[float, float]) -> set[tuple[int, int]]:
    """The places of set cells, counted from the world's origin."""
    rows, columns = np.nonzero(cells)
    low, left = round(origin_m[1] / 0.05), round(origin_m[0] / 0.05)
    return {(int(row) + low, int(column) + left) for row, column in zip(rows, columns, strict=True)}


def test_with_one_robot_the_grid_is_its_own_map():
    """Its submaps, drawn anew at the solved anchors; a drawing may lie half a centimetre beside."""
    mine = [update for name, update in mission() if name == "r1"]
    team = TeamMap()
    team.add_robot("r1", None)
    for update in mine:
        team.put("r1", update)
    solved = team.solve()
    assert solved.grid is not None
    own = FusedGrid(0.05)
    for submap in mine[-1].submaps:
        anchor = Pose2.from_array(robot(solved, "r1").anchors[submap.anchor])
        own.put(submap.anchor, submap.version, anchor @ submap.anchor_from_grid, unpack(submap))
    grid = solved.grid.cells
    for mine_, theirs in (
        (own.cells > 4, grid > 60),
        (own.cells < -4, (grid >= 0) & (grid < 40)),
        (own.cells != 0, grid >= 0),
    ):
        expected, found = cells_at(mine_, own.origin), cells_at(theirs, solved.grid.origin_m)
        assert len(expected) > 200
        assert len(expected & found) > 0.85 * len(expected | found)
    assert solved.explored_m2 == pytest.approx(float((own.cells <= -4).sum()) * 0.0025, rel=0.02)
    assert (grid[[0, -1]] >= 0).any(axis=1).all()  # cut to what is known
    assert (grid[:, [0, -1]] >= 0).any(axis=0).all()


def test_a_map_of_true_poses_is_the_building():
    """Occupied cells lie on walls, free cells do not, in the world of the survey."""
    result = run(ScenarioConfig(map="office:100", robots=2, minutes=1.0, seed=6, poses="truth", victims=0))
    team = TeamMap()
    for member in result.robots:
        team.add_robot(member.robot_id, StartPose(member.start, 0.001, 0.001))
        team.put(member.robot_id, member.report)
    grid = team.solve().grid
    assert grid is not None
    world = result.world
    for cells, walls, least in (
        (grid.cells > 65, True, 0.93),
        ((grid.cells >= 0) & (grid.cells < 35), False, 0.99),
    ):
        rows, columns = np.nonzero(cells)
        x = grid.origin_m[0] + (columns + 0.5) * grid.resolution_m
        y = grid.origin_m[1] + (rows + 0.5) * grid.resolution_m
        at = [world.cell(float(a), float(b)) for a, b in zip(x, y, strict=True)]
        solid = [(world.cells[r - 1 : r + 2, c - 1 : c + 2] & 1).any() for r, c in at] if walls else [
            not world.cells[r, c] & 1 for r, c in at
        ]  # fmt: skip
        assert len(solid) > 100
        assert np.mean(solid) > least
