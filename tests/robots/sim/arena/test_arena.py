"""Runs of the arena in buildings small enough for a test."""

from dataclasses import replace
from math import hypot, inf

import numpy as np
import pytest

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig
from robots.sim.arena.config import STEP_M, ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.reader import BelievedPlaces
from robots.sim.arena.result import leaves_a_hole
from robots.sim.arena.robot import ArenaRobot
from robots.sim.arena.run import Arena, play
from robots.sim.scenario import ScenarioConfig, ScenarioError
from robots.sim.sensors import LaserConfig
from robots.sim.tags import TagField

AGENT = AgentConfig(planning=PlanningConfig(explore="nearest"), deployment=DeploymentConfig(even_m=1.0))
TWO = ScenarioConfig("office:60", robots=2, seed=3, poses="truth", victims=0, agent_config=AGENT)
SILENT = replace(
    TWO,
    base_tag=False,
    agent_config=AgentConfig(
        planning=PlanningConfig(explore="nearest", communication="none"),
        deployment=DeploymentConfig(magazine=0),
    ),
)
CONFIG = ArenaConfig(TWO, budget_m=8.0)


def test_the_same_run_comes_to_the_same_and_another_seed_does_not():
    first, second = play(CONFIG), play(CONFIG)
    assert first.covered_m2.tolist() == second.covered_m2.tolist()
    assert (first.score, first.steps, first.tags) == (second.score, second.steps, second.tags)
    assert play(replace(CONFIG, scenario=replace(TWO, seed=4))).score != first.score


def test_in_sequence_each_drives_its_budget_and_leaves_tags_that_hold_what_it_saw():
    arena = Arena(CONFIG, ground_of(TWO))
    result = arena.play()
    for robot in arena.robots:
        assert 8.0 - 1e-6 <= robot.driven_m < 8.0 + STEP_M or robot.decision.activity == "done"
    assert result.driven_m[-1] == pytest.approx(sum(robot.driven_m for robot in arena.robots))
    assert result.score == pytest.approx(result.covered_m2[-1] / result.driven_m[-1])
    assert len(arena.field.tags) > 3
    assert all(tag.chip is not None and tag.chip.chip.bits == 2048 for tag in arena.field.tags)
    assert sum(bool(tag.memory) for tag in arena.field.tags) > 2
    read = arena.robots[1].scout.explorer.claims.tags(arena.robots[1].places.of)
    assert any(tag.tag_id.startswith("r1-") for tag in read)


def test_what_the_laser_truly_saw_is_what_counts():
    arena = Arena(CONFIG, ground_of(TWO))
    result = arena.play()
    union = (arena.robots[0].seen | arena.robots[1].seen) > 0
    area = float((union & arena.ground.observable).sum()) * arena.ground.world.resolution_m**2
    assert result.covered_m2[-1] == pytest.approx(area)


def test_one_map_for_all_spares_the_second_robot_the_first_ones_ways():
    scores = {False: 0.0, True: 0.0}
    for seed in range(4):
        team = replace(SILENT, map="office:150", robots=3, seed=seed)
        for one_map in scores:
            scores[one_map] += play(ArenaConfig(team, one_map=one_map, budget_m=10.0)).score
    assert scores[True] > 1.5 * scores[False]
    together = Arena(ArenaConfig(SILENT, one_map=True, budget_m=8.0), ground_of(SILENT))
    together.play()
    assert together.robots[0].map.cells is together.robots[1].map.cells
    assert len(together.field.tags) == 0


def test_who_starts_when_the_others_have_gone_is_told_all_that_they_saw():
    """One after another by messages, as good as on one map; nobody that saw it speaks any more."""
    one_map = replace(SILENT, map="office:150", robots=3)
    told = replace(
        one_map,
        agent_config=AgentConfig(
            planning=PlanningConfig(explore="nearest", communication="full"),
            deployment=DeploymentConfig(magazine=0),
        ),
    )
    scores = {"told": 0.0, "one map": 0.0}
    for seed in range(6):
        on_one = ArenaConfig(replace(one_map, seed=seed), one_map=True, budget_m=10.0)
        scores["one map"] += play(on_one).score
        scores["told"] += play(ArenaConfig(replace(told, seed=seed), budget_m=10.0)).score
    assert scores["told"] > 0.93 * scores["one map"]


def test_robots_that_know_the_same_do_the_same_and_those_that_talk_do_not():
    """With a perfect laser, at one place: the hardest start."""
    team = replace(SILENT, laser=LaserConfig(sd_m=0.0))
    arena = Arena(ArenaConfig(team, budget_m=8.0), ground_of(team))
    arena.play()
    assert np.array_equal(arena.robots[0].seen, arena.robots[1].seen)
    planning = PlanningConfig(explore="nearest", communication="full", coordinate="exclusion")
    team = replace(team, map="office:150", agent_config=replace(AGENT, planning=planning))
    talking = Arena(ArenaConfig(team, "at once", budget_m=8.0, limit_s=60.0), ground_of(team))
    talking.play()
    assert (talking.robots[0].seen != talking.robots[1].seen).mean() > 0.02


def test_all_at_once_time_and_way_go_on_until_all_is_seen():
    result = play(replace(CONFIG, in_order="at once", until=0.95, budget_m=inf))
    assert result.coverage >= 0.95
    assert result.reached_s(0.5) < result.reached_s(0.9) < result.stamps_s[-1] + 0.1
    assert result.reached_s(1.0) is None
    assert (np.diff(result.driven_m) <= 2 * STEP_M + 1e-9).all()
    assert (np.diff(result.covered_m2) >= 0.0).all()
    assert (result.times_stuck, result.false_ends) == (0, 0)


def test_robots_that_collide_never_overlap():
    arena = Arena(replace(CONFIG, in_order="at once", collide=True, budget_m=inf), ground_of(TWO))
    radius_m = AGENT.body.radius_m
    a, b = arena.robots
    nearest = inf
    for tick in range(150):
        for robot in (a, b):
            robot.step(0.4 * tick, arena._others(robot))
        nearest = min(nearest, hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y))
    assert nearest >= 2.0 * radius_m - 1e-6
    assert a.driven_m + b.driven_m > 20.0


def test_a_robot_that_is_done_has_seen_all_there_is():
    scenario = replace(TWO, robots=1)
    arena = Arena(replace(CONFIG, scenario=scenario, budget_m=200.0), ground_of(scenario))
    result = arena.play()
    (robot,) = arena.robots
    assert robot.decision.activity == "done"
    assert not leaves_a_hole(robot.seen, arena.ground)
    assert result.false_ends == 0
    robot.seen[arena.ground.world.cell(robot.pose.x, robot.pose.y)[0] :] = 0
    assert leaves_a_hole(robot.seen, arena.ground)


def test_believed_places_are_off_by_the_same_each_time_and_by_as_much_as_told():
    field, start = TagField(0), ground_of(TWO).starts[0]
    for k in range(400):
        field.drop(f"T{k}", start.x + k, start.y)
    exact, first, again, other = (
        BelievedPlaces(field, start, error_m, seed)
        for error_m, seed in ((0.0, (1, 2)), (0.3, (1, 2)), (0.3, (1, 2)), (0.3, (1, 3)))
    )
    for places in (exact, first, again, other):
        for k in range(400):
            places.learn(f"T{k}")
    assert np.allclose(exact.all(), [(k, 0.0) for k in range(400)])
    assert first.all() == again.all() != other.all()
    assert np.std(np.subtract(first.all(), exact.all())) == pytest.approx(0.3, rel=0.1)
    assert exact.of("nobody's") is None


def test_what_cannot_be_played_is_refused():
    with pytest.raises(ScenarioError, match="poses=truth"):
        ArenaConfig(replace(TWO, poses="slam"), budget_m=1.0)
    with pytest.raises(ScenarioError, match="budget_m"):
        ArenaConfig(TWO)
    with pytest.raises(ScenarioError, match="reader_m"):
        replace(CONFIG, reader_m=-1.0)


@pytest.mark.parametrize("explore", ["waymark", "kleiner", "ziparo"])
def test_clocks_that_disagree_by_hours_change_nothing(monkeypatch, explore):
    """Robots meet in tags alone, and those tell counts, not times."""
    agent = replace(AGENT, planning=PlanningConfig(explore=explore))
    config = replace(CONFIG, scenario=replace(TWO, agent_config=agent), in_order="at once")
    step, found_by = ArenaRobot.step, {}
    for ahead_s in (0.0, 8192.0):

        def by_its_clock(robot, clock_s, others_m, heard=(), ahead_s=ahead_s):
            return step(robot, clock_s + 8192.0 + ahead_s * (robot.robot_id == "r2"), others_m, heard)

        monkeypatch.setattr(ArenaRobot, "step", by_its_clock)
        arena = Arena(config, ground_of(config.scenario))
        found_by[ahead_s] = arena.play(), [tag.memory for tag in arena.field.tags]
    (expected, told), (found, told_again) = found_by.values()
    assert told_again == told
    assert found.covered_m2.tolist() == expected.covered_m2.tolist()
    assert (found.driven_m.tolist(), found.tags) == (expected.driven_m.tolist(), expected.tags)
    assert found.tags > 3
