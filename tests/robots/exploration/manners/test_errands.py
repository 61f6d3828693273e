"""What an operator orders, and what is told of it."""

import numpy as np
import pytest

from robots.exploration.manners.homing import HOME_M
from robots.orders import Methods, RobotOrder
from robots.se2 import Pose2


def give(robot, kind, place_m=None, tags_left=5, order_id="o1", **methods):
    robot.explorer.take(RobotOrder(order_id, kind, "Ann", place_m, Methods(**methods)), tags_left)


def told(robot):
    return [(report.order_id, report.state, report.text) for report in robot.explorer.order_reports()]


def test_return_takes_it_to_the_base_where_it_waits_until_it_may_resume(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2(8.0, 0.0, 0.0))
    give(robot, "return")
    first = robot.drive(1.0)
    assert first.reason.startswith("driving 8 m to the base: ordered by Ann")
    assert told(robot) == []
    robot.drive(60.0, lambda d: d.activity == "holding")
    assert told(robot) == [("o1", "done", "I am at the base")]
    assert np.hypot(robot.pose.x, robot.pose.y) <= HOME_M
    assert robot.drive(20.0).linear_mps == 0.0
    give(robot, "resume", order_id="o2")
    assert robot.drive(1.0).activity == "exploring"
    assert told(robot) == [("o2", "done", "exploring")]


def test_hold_stands_still_and_says_for_whom(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    robot.drive(2.0)
    give(robot, "hold")
    before = len(robot.seen)
    assert robot.drive(30.0).reason == "standing still, ordered by Ann"
    assert all(d.linear_mps == d.angular_radps == 0.0 for d in robot.seen[before:])
    assert told(robot) == [("o1", "done", "standing still")]


def test_go_to_a_point_and_wait_there(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    give(robot, "go_to", (7.0, 2.0))
    assert "to the place ordered by Ann" in robot.drive(1.0).reason
    last = robot.drive(60.0, lambda d: d.activity == "holding")
    np.testing.assert_allclose([robot.pose.x, robot.pose.y], [7.0, 2.0], atol=0.45)
    assert last.reason == "waiting at the place, ordered by Ann"
    assert told(robot) == [("o1", "done", "at the place; it waits there")]


def test_a_point_that_was_not_seen_yet_is_headed_for_along_the_edge(rover, make_hall):
    robot = rover(make_hall(known_to_m=8.0), Pose2())
    give(robot, "go_to", (14.0, 1.0))
    assert "towards the place ordered by Ann: not seen yet" in robot.drive(10.0).reason
    robot.fused = make_hall()
    robot.drive(60.0, lambda d: d.activity == "holding")
    np.testing.assert_allclose([robot.pose.x, robot.pose.y], [14.0, 1.0], atol=0.45)


def test_a_point_that_cannot_be_reached_fails_in_words_and_it_explores_on(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0, walls=((5.0, 0.0, 9.0, 3.0),)), Pose2())
    give(robot, "go_to", (7.2, 1.5))
    robot.drive(60.0)
    assert told(robot) == [("o1", "failed", "there is no way to the place")]
    assert robot.seen[-1].activity == "exploring"


@pytest.mark.parametrize("place", [None, (float("nan"), 0.0), (float("inf"), 1.0)])
def test_an_order_without_a_place_changes_nothing(rover, make_hall, place):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    give(robot, "go_to", place)
    assert told(robot) == [("o1", "failed", "it names no place on the map")]
    assert robot.drive(1.0).activity == "exploring"


def test_explore_here_goes_to_the_edges_near_the_place_first(rover, make_hall):
    behind = ((-1.5, -1.5, -0.5, 4.5),)  # an edge near the base as well
    robot = rover(make_hall(40.0, known_to_m=30.0, unseen=behind), Pose2(1.0, 0.0, 0.0))
    give(robot, "explore_here", (26.0, 0.0))
    robot.drive(1.0)
    assert robot.seen[-1].goal_m == (26.0, 0.0)
    robot.drive(90.0, lambda d: d.reason.startswith("looking"))
    assert robot.pose.x > 25.0
    assert told(robot) == []
    robot.fused = make_hall(40.0, unseen=behind)
    robot.drive(10.0)
    assert told(robot) == [("o1", "done", "no edge of the unknown is left near the place")]
    assert robot.seen[-1].goal_m[0] < 1.0


def test_an_area_is_explored_before_what_is_nearer(rover, make_hall):
    behind = ((-1.5, -1.5, -0.5, 4.5), (18.0, -2.0, 19.0, 2.0))  # edges outside the area, one on its way
    robot = rover(make_hall(40.0, known_to_m=30.0, unseen=behind), Pose2(1.0, 0.0, 0.0))
    area = ((24.0, -4.0), (34.0, -4.0), (34.0, 8.0), (24.0, 8.0))
    robot.explorer.take(RobotOrder("o1", "explore_here", "Ann", (26.0, 0.0), area_m=area), 5)
    robot.drive(90.0, lambda d: d.reason.startswith("looking"))
    assert robot.pose.x > 23.0
    assert 24.0 - 1.0 <= robot.seen[-1].goal_m[0] <= 35.0
    assert told(robot) == []
    robot.fused = make_hall(40.0, unseen=behind)
    robot.drive(10.0)
    assert told(robot) == [("o1", "done", "no edge of the unknown is left in the area")]
    assert robot.seen[-1].goal_m[0] < 24.0


def test_a_later_order_takes_the_place_of_the_first(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    give(robot, "go_to", (7.0, 2.0))
    robot.drive(2.0)
    give(robot, "return", order_id="o2")
    assert told(robot) == [("o1", "failed", "given up for a later order: return")]


def test_a_low_battery_overrules_an_order_and_says_so(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2(3.0, 0.0, 0.0))
    robot.battery = 0.04
    give(robot, "go_to", (7.0, 2.0))
    assert robot.drive(2.0).activity == "returning"
    assert told(robot) == [("o1", "failed", "going back instead: the battery is at 4 %")]


def test_a_tag_is_dropped_where_it_stands_unless_the_magazine_is_empty(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    give(robot, "drop_tag", tags_left=0)
    assert told(robot) == [("o1", "failed", "the magazine is empty")]
    give(robot, "drop_tag", order_id="o2")
    assert robot.drive(0.2).drop_tag
    robot.explorer.errands.tag_dropped()
    assert told(robot) == [("o2", "done", "dropped a tag")]
    assert not robot.drive(0.2).drop_tag


def test_methods_change_while_it_runs_and_unknown_ones_are_refused_with_the_known(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    assert "to the nearest edge" in robot.drive(1.0).reason
    give(robot, "methods", explore="information-gain")
    assert "m² of new ground" in robot.drive(1.0).reason
    assert robot.explorer.errands.methods.explore == "information-gain"
    give(robot, "methods", order_id="o2", explore="astrology")
    (done, failed) = told(robot)
    assert done == ("o1", "done", "explore by information-gain")
    assert failed[:2] == ("o2", "failed")
    assert "'astrology'; known are " in failed[2]
    assert "nearest" in failed[2]
    assert robot.explorer.errands.methods.explore == "information-gain"
