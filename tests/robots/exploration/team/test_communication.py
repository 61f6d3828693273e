"""One robot among others that talk: with whom it shares the unknown, and whose ground it plans on."""

import numpy as np
import pytest

from robots.config import AgentConfig, PlanningConfig
from robots.exploration.frontiers import Frontier
from robots.exploration.goals import Goals
from robots.exploration.strategies.nearest import Nearest
from robots.exploration.strategy import ExplorationView
from robots.exploration.team.communication import MATE_FOR_S, SAY_EVERY_S, Communication
from robots.exploration.team.team_message import decode_message
from robots.exploration.told.survey import Survey
from robots.mapping.fused import FusedGrid
from robots.se2 import Pose2

CONFIG = AgentConfig(planning=PlanningConfig(communication="full"))


def robot(name, *start, **told):
    made = Communication(
        name, AgentConfig(planning=PlanningConfig(**({"communication": "full"} | told)), start=start)
    )
    made.hear(0.0, True, ())
    return made


def ground(value=-20):
    fused = FusedGrid(0.05)
    fused.put("all", 0, Pose2(), np.full((64, 64), value, np.int16))
    return fused


def team_of(listener, now_s):
    frontier = Frontier((0, 0), (1.0, 1.0), 1.0, 1.0)
    survey = Survey(np.ones((4, 4)), np.zeros((4, 4), np.uint8), (0.0, 0.0))
    return listener.team(ExplorationView(Pose2(), (frontier,), lambda: survey, now_s=now_s), Nearest(), None)


def test_others_are_where_they_say_in_this_robots_own_map():
    here, there = robot("r1", 10.0, 5.0, 0.3), robot("r2", 4.0, 1.0, 2.0)
    said = there.say(0.0, Pose2(1.0, 2.0, 0.5), (3.0, 3.0), ground(), 4.0)
    here.hear(0.2, True, (said,))
    team = team_of(here, 0.2)
    assert team.ids == ("r1", "r2")
    assert team.goals_m[1] == pytest.approx((-3.0, -1.0))
    assert team.straight(1)[0] == pytest.approx(np.hypot(1.0 + 5.0, 1.0 + 2.0))


def test_the_ways_of_others_lead_straight_to_their_goals_until_they_are_heard_no_more():
    here, there = robot("r1", 10.0, 5.0, 0.3), robot("r2", 4.0, 1.0, 2.0)
    assert here.mates_ways(0.0).shape == (0, 3)
    said = there.say(0.0, Pose2(1.0, 2.0, 0.5), (1.0, 7.5), ground(), 4.0)
    here.hear(0.2, True, (said,))
    ways = here.mates_ways(0.2)
    assert ways[[0, -1], :2] == pytest.approx(np.array([(-5.0, -2.0), (-5.0, 3.5)]), abs=0.01)
    assert np.diff(ways[:, 1]).max() <= 1.0
    assert ways[:, 2] == pytest.approx(np.pi / 2)
    assert here.mates_ways(0.2 + MATE_FOR_S + 1.0).shape == (0, 3)


def test_without_a_compass_the_map_lies_as_the_robot_stood():
    turned = Communication("r1", AgentConfig(planning=CONFIG.planning, start=(1.0, 1.0, np.pi / 2)))
    turned.hear(0.0, False, ())
    message = decode_message(turned.say(0.0, Pose2(2.0, 0.0, 0.0), None, ground(), 4.0))
    assert (message.pose.x, message.pose.y) == pytest.approx((1.0, 3.0))
    assert message.pose.theta == pytest.approx(np.pi / 2)


def test_only_those_that_explore_and_were_heard_lately_share():
    here, there, busy = robot("r1", 0.0, 0.0, 0.0), robot("r2", 1.0, 0.0, 0.0), robot("r3", 2.0, 0.0, 0.0)
    here.hear(
        0.0,
        True,
        (there.say(0.0, Pose2(), None, ground(), 4.0), busy.say(0.0, Pose2(), None, ground(), 4.0, True)),
    )
    assert team_of(here, 0.0).ids == ("r1", "r2")
    assert team_of(here, MATE_FOR_S + 0.1).ids == ("r1",)


def test_it_says_why_it_leaves_the_nearest_edge_to_another():
    told = PlanningConfig(explore="nearest", communication="full", coordinate="exclusion")
    here = Communication("r1", AgentConfig(planning=told, start=(0.0, 0.0, 0.0)))
    here.hear(0.0, True, ())
    goals = Goals(told, here)
    near, far = Frontier((0, 0), (2.0, 0.0), 1.0, 2.0), Frontier((0, 0), (0.0, 9.0), 1.0, 9.0)
    survey = Survey(np.ones((4, 4)), np.zeros((4, 4), np.uint8), (0.0, 0.0))
    view = ExplorationView(Pose2(), (near, far), lambda: survey)
    assert goals.choose(view).why == "the nearest edge of the unknown, 1.0 m wide"
    other = robot("r2", 1.0, 0.0, 0.0).say(0.0, Pose2(), (1.0, 0.0), ground(), 4.0)
    here.hear(0.0, True, (other,))
    choice = goals.choose(view)
    assert choice.frontier is far
    assert choice.why == "an edge of the unknown, 1.0 m wide, away from where others go"


def test_it_speaks_once_a_second_at_most_and_only_when_told_to():
    talker = robot("r1", 0.0, 0.0, 0.0)
    said = [talker.say(0.2 * k, Pose2(), None, ground(), 4.0) for k in range(26)]
    assert sum(message is not None for message in said) == 1 + int(5.0 / SAY_EVERY_S)
    for kind in ("none", "tags"):
        silent = robot("r2", 0.0, 0.0, 0.0, communication=kind)
        assert silent.say(0.0, Pose2(), None, ground(), 4.0) is None
        assert silent.hear(0.0, True, (said[0],)) == ()
        own = ground()
        assert silent.overlaid(own) is own


def test_what_others_saw_is_planned_on_where_their_starts_put_it():
    here, there = robot("r1", 10.0, 5.0, 0.0), robot("r2", 4.0, 1.0, 0.0)
    for now_s in (0.0, 1.0):
        hello = here.say(now_s, Pose2(), None, FusedGrid(0.05), 4.0)
        there.hear(now_s, True, (hello,))
        here.hear(now_s, True, (there.say(now_s, Pose2(1.0, 1.0, 0.0), None, ground(), 4.0),))
    own = ground()
    seen = here.overlaid(own)
    rows, columns = np.nonzero(seen.cells)
    x, y = seen.origin[0] + (columns + 0.5) * 0.05, seen.origin[1] + (rows + 0.5) * 0.05
    assert (x.min(), y.min()) == pytest.approx((4.0 - 10.0, 1.0 - 5.0), abs=0.11)
    assert len(rows) == pytest.approx(2 * 64 * 64, rel=0.05)
