"""What robots' agents say that people have to know: raised once, ended once, told with reasons."""

import asyncio
from types import SimpleNamespace

import pytest

from robots.se2 import Pose2
from server.mission.robot_alerts import RobotAlerts


class Told:
    """Alerts and events that only note what they are told."""

    def __init__(self):
        self.on = {}
        self.told = []

    def is_on(self, kind, subject):
        return (kind, subject) in self.on

    async def raise_(self, kind, subject, text, severity, *, event, robot_id):
        if self.on.get((kind, subject)) != severity:
            self.on[kind, subject] = severity
            self.told.append((kind, severity, text))

    async def end(self, kind, subject, text, *, event):
        if self.on.pop((kind, subject), None):
            self.told.append((kind, "over", text))

    async def tell(self, kind, text, robot_id):
        self.told.append((kind, "event", text))


@pytest.fixture
def watch():
    told = Told()
    alerts = RobotAlerts(told, told)

    def look(stamp_s, activity="exploring", slipping=False, battery=1.0, tags_left=50, x_m=0.0):
        update = SimpleNamespace(
            stamp_s=stamp_s,
            activity=activity,
            reason="why",
            slipping=slipping,
            tags_left=tags_left,
            pose=Pose2(x_m, 0.0),
        )
        asyncio.run(alerts.look(SimpleNamespace(robot_id="r1", update=update, battery=battery)))
        taken, told.told = told.told, []
        return taken

    return look


def backings_off(watch, stamps_s, x_m=0.0, per_s=0.0):
    """Back off at these times, each for 1.4 s, and come so far each second; return what was told."""
    told = []
    for stamp_s in stamps_s:
        here = x_m + per_s * (stamp_s - stamps_s[0])
        told += watch(stamp_s, "stuck", x_m=here) + watch(stamp_s + 1.0, "stuck", x_m=here - 0.15)
        told += watch(stamp_s + 1.4, x_m=here)
    return told


def test_a_robot_that_gets_nowhere_is_stuck_until_it_gets_away(watch):
    assert watch(0.0) == []
    assert backings_off(watch, (10.0, 20.0, 30.0)) == []
    assert watch(40.0) == []  # long enough, but it drives
    assert backings_off(watch, (41.0,)) == [("stuck", "warning", "r1 is stuck: why.")]
    assert backings_off(watch, (50.0, 70.0)) == []
    assert watch(75.0, x_m=0.9) == []
    assert watch(76.0, x_m=1.1) == [("stuck", "over", "r1 is free again.")]


def test_a_robot_that_is_not_stuck_for_a_while_is_free(watch):
    assert len(backings_off(watch, (10.0, 20.0, 30.0, 40.0))) == 1
    assert watch(71.0) == []
    assert watch(71.5) == [("stuck", "over", "r1 is free again.")]
    assert backings_off(watch, (80.0, 90.0)) == []  # counted anew


def test_a_robot_among_robots_is_not_stuck(watch):
    """It backs off before one that comes out of a door as often as it takes, goes aside, and gets past."""
    assert backings_off(watch, (1.0, 6.0, 11.0, 16.0)) == []
    assert watch(25.0, x_m=1.2) == []  # gone aside, back again,
    assert backings_off(watch, (30.0, 35.0)) == []
    assert watch(50.0, x_m=3.0) == []  # and through
    assert backings_off(watch, tuple(60.0 + 8.0 * k for k in range(20)), per_s=0.1) == []  # one ahead is slow


def test_two_robots_that_never_get_past_each_other_are_stuck(watch):
    told = backings_off(watch, tuple(1.0 + 12.0 * k for k in range(6)), per_s=0.005)
    assert told == [("stuck", "warning", "r1 is stuck: why.")]


def test_slipping_counts_by_its_share_of_the_time(watch):
    watch(0.0)
    told = [kind for k in range(1, 200) for kind, *_ in watch(0.1 * k, slipping=k % 20 == 0)]
    assert told == []
    told = [entry for k in range(200, 400) for entry in watch(0.1 * k, slipping=True)]
    assert [kind for kind, *_ in told] == ["slipping"]
    told = [entry for k in range(400, 900) for entry in watch(0.1 * k)]
    assert [(kind, state) for kind, state, _ in told] == [("slipping", "over")]


def test_a_battery_that_runs_down_is_told_twice(watch):
    found = [entry for k in range(100) for entry in watch(float(k), battery=(100 - k) / 100)]
    assert [(state, text) for _, state, text in found] == [
        ("warning", "The battery of r1 is down to 19%."),
        ("alarm", "The battery of r1 is down to 9%."),
    ]
    assert watch(101.0, battery=0.15) == []
    assert watch(102.0, battery=None) == []
    assert watch(103.0, battery=0.9) == [("battery", "over", "The battery of r1 is at 90% again.")]


def test_a_magazine_that_runs_out(watch):
    assert watch(0.0, tags_left=4) == []
    assert watch(1.0, tags_left=3) == [("magazine", "warning", "r1 has 3 tags left.")]
    assert watch(2.0, tags_left=0) == []
    assert watch(3.0, tags_left=5) == []
    assert watch(4.0, tags_left=20) == [("magazine", "over", "r1 has 20 tags again.")]


def test_being_done_is_told_once(watch):
    watch(0.0)
    assert watch(1.0, "done") == [("done", "event", "r1 is done: why.")]
    assert watch(2.0, "done") == []
