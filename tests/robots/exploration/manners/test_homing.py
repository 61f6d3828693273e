"""Going back in time: by the battery, by the clock, and to the last contact where home is out of reach."""

from math import hypot

import numpy as np
import pytest

from robots.config import BodyConfig, PlanningConfig
from robots.exploration.manners.homing import HOME_M, Homing
from robots.se2 import Pose2


def from_base(rover) -> float:
    return hypot(rover.pose.x, rover.pose.y)


@pytest.mark.parametrize("use_per_m", [0.002, 0.01, 0.03])
def test_on_a_low_battery_it_leaves_while_the_rest_still_reaches_the_base(rover, make_hall, use_per_m):
    robot = rover(make_hall(40.0, known_to_m=36.0), Pose2())
    robot.battery, robot.use_per_m = 1.0, use_per_m
    for far in (10.0, 20.0, 30.0):  # the edge lies farther and farther off
        robot.fused = make_hall(40.0, known_to_m=far)
        robot.drive(120.0, lambda d: d.activity != "exploring" or d.reason.startswith("looking"))
    last = robot.drive(400.0, lambda d: d.activity == "done")
    assert last.activity == "done"
    assert from_base(robot) <= HOME_M
    assert robot.battery > 0.03  # of the reserve of a tenth
    if use_per_m > 0.02:
        assert "the battery is at" in last.reason
        assert any(
            d.reason.startswith("driving") and "to the base: the battery" in d.reason for d in robot.seen
        )


def test_a_changed_battery_lets_it_go_on(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2(5.0, 0.0, 0.0))
    robot.battery = 0.05
    assert robot.drive(60.0, lambda d: d.activity == "done").activity == "done"
    robot.battery = 0.9
    assert robot.drive(6.0).activity == "exploring"


def test_what_a_metre_takes_is_learnt():
    homing = Homing(PlanningConfig(), BodyConfig())
    for k in range(2001):
        homing.observe(float(k), Pose2(0.1 * k, 0.0, 0.0), 1.0 - 0.004 * 0.1 * k)
    assert homing.use_per_m == pytest.approx(0.004, rel=0.2)
    homing.observe(2002.0, Pose2(500.0, 0.0, 0.0), 0.2)  # the map jumped: nothing was driven
    assert homing.use_per_m == pytest.approx(0.004, rel=0.2)


@pytest.mark.parametrize("battery", [None, float("nan")])
def test_without_a_battery_that_tells_it_explores_on(rover, make_hall, battery):
    robot = rover(make_hall(known_to_m=15.0), Pose2(5.0, 0.0, 0.0))
    robot.battery = battery
    assert robot.drive(3.0).activity == "exploring"


@pytest.mark.parametrize("mission_s", [60.0, 120.0])
def test_it_is_back_when_the_mission_ends(rover, make_hall, mission_s):
    robot = rover(make_hall(60.0, known_to_m=50.0), Pose2(), mission_s=mission_s)
    last = robot.drive(mission_s)
    assert from_base(robot) <= HOME_M
    assert last.reason.endswith("I am at the base")
    farthest = max(float(d.path_m[0, 0]) for d in robot.seen if len(d.path_m))
    assert farthest > 0.14 * mission_s  # and did not turn back much too early
    assert robot.drive(10.0).reason == "the mission's time is over; I am at the base"


def test_a_battery_that_does_not_reach_home_takes_it_to_the_last_contact(rover, make_hall):
    robot = rover(make_hall(40.0, known_to_m=35.0), Pose2(30.0, 0.0, 0.0))
    robot.explorer.homing.hear(Pose2(26.0, 1.0, 0.0))
    robot.battery, robot.use_per_m = 0.012, 0.001
    last = robot.drive(60.0, lambda d: d.activity == "done")
    assert last.reason.endswith("I am at where others were heard last")
    np.testing.assert_allclose([robot.pose.x, robot.pose.y], [26.0, 1.0], atol=HOME_M)
    assert robot.battery > 0.0


def test_home_that_is_crowded_is_home_nearby_and_one_that_is_shut_is_told(rover, make_hall):
    crowded = make_hall(walls=((-1.5, -1.5, 2.5, 2.5),))
    robot = rover(crowded, Pose2(8.0, 0.0, 0.0), mission_s=1.0)
    last = robot.drive(60.0, lambda d: d.activity == "done")
    assert "as near to the base as I can get" in last.reason
    shut = make_hall(walls=((9.0, -1.5, 9.2, 4.5),))
    robot = rover(shut, Pose2(14.0, 0.0, 0.0), mission_s=1.0)
    last = robot.drive(60.0)
    assert (last.activity, last.linear_mps) == ("returning", 0.0)
    assert "the way to the base is shut for now" in last.reason
