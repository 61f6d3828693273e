"""What robots' agents say that people have to know: raised once, ended once, told with reasons."""

import asyncio
from types import SimpleNamespace

import pytest

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

    def look(stamp_s, activity="exploring", slipping=False, battery=1.0, tags_left=50):
        update = SimpleNamespace(
            stamp_s=stamp_s, activity=activity, reason="why", slipping=slipping, tags_left=tags_left
        )
        asyncio.run(alerts.look(SimpleNamespace(robot_id="r1", update=update, battery=battery)))
        taken, told.told = told.told, []
        return taken

    return look


def test_a_robot_that_gets_stuck_again_and_again_is_stuck_until_it_is_free_for_a_while(watch):
    assert watch(0.0) == []
    for stamp_s in (10.0, 20.0):
        assert watch(stamp_s, "stuck") == []
        assert watch(stamp_s + 2.0) == []
    assert watch(30.0, "stuck") == [("stuck", "warning", "r1 is stuck: why.")]
    assert watch(31.0, "stuck") == []
    assert watch(50.0) == []
    assert watch(95.0) == [("stuck", "over", "r1 is free again.")]


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
