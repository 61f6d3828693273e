"""Noticing that driving leads nowhere: by time, by bumps, and when it happens again and again."""

import pytest

from robots.exploration.manners.recovery import Recovery, place_ahead
from robots.se2 import Pose2

HERE = Pose2(1.0, 2.0, 0.5)


def watching(now_s: float = 0.0) -> Recovery:
    recovery = Recovery(stuck_after_s=6.0)
    assert not recovery.begins(now_s, HERE, bumped=False)
    return recovery


def test_without_progress_it_backs_off_after_the_time_it_was_given():
    recovery = watching()
    assert not any(recovery.begins(now_s, HERE, bumped=False) for now_s in (2.0, 4.0, 6.0))
    assert recovery.velocities(6.0) is None
    assert recovery.begins(6.1, HERE, bumped=False)
    assert recovery.active


@pytest.mark.parametrize("moved", [Pose2(1.2, 2.0, 0.5), Pose2(1.0, 2.0, 1.1), Pose2(1.0, 2.0, -0.1)])
def test_driving_or_turning_is_progress(moved):
    recovery = watching()
    assert not any(recovery.begins(now_s, HERE, bumped=False) for now_s in (2.0, 4.0))
    assert not any(recovery.begins(now_s, moved, bumped=False) for now_s in (5.0, 7.0, 9.0, 11.0))
    assert recovery.begins(11.5, moved, bumped=False)


def test_trembling_is_not():
    recovery = watching()
    found = [
        recovery.begins(0.5 * k, Pose2(1.0 + 0.1 * (k % 2), 2.0, 0.5), bumped=False) for k in range(1, 14)
    ]
    assert found == [False] * 12 + [True]


def test_a_bump_counts_at_once_even_while_driving():
    assert watching().begins(0.2, HERE, bumped=True)
    assert watching().begins(0.2, Pose2(9.0, 9.0), bumped=True)


def test_backing_off_ends_and_the_clock_starts_anew():
    recovery = watching()
    recovery.begins(1.0, HERE, bumped=True)
    linear, angular = recovery.velocities(2.0)
    assert linear < 0.0
    assert angular != 0.0
    assert recovery.velocities(2.5) is None
    assert not recovery.active
    assert not any(recovery.begins(now_s, HERE, bumped=False) for now_s in (3.0, 5.0, 7.0, 8.9))
    assert recovery.begins(9.1, HERE, bumped=False)


def test_it_turns_to_the_other_side_the_next_time():
    recovery = watching()
    turns = []
    for now_s in (1.0, 4.0):
        recovery.begins(now_s, HERE, bumped=True)
        turns.append(recovery.velocities(now_s)[1])
        recovery.velocities(now_s + 2.0)
        recovery.begins(now_s + 2.0, HERE, bumped=False)
    assert turns[0] == -turns[1]


def test_twice_in_a_short_time_is_failing_and_can_be_forgotten():
    recovery = watching()
    recovery.begins(1.0, HERE, bumped=True)
    assert not recovery.keeps_failing
    recovery.begins(10.0, HERE, bumped=True)
    assert recovery.keeps_failing
    recovery.forget()
    assert not recovery.keeps_failing


def test_twice_in_a_long_time_is_not():
    recovery = watching()
    recovery.begins(1.0, HERE, bumped=True)
    recovery.begins(60.0, HERE, bumped=True)
    assert not recovery.keeps_failing


def test_resting_is_not_being_stuck():
    recovery = watching()
    for second in range(1, 30):
        recovery.rest()
        assert not recovery.begins(float(second), HERE, bumped=False)


def test_a_robot_that_did_not_decide_for_a_while_was_not_driving():
    recovery = watching()
    assert not recovery.begins(7.0, HERE, bumped=False)
    assert not recovery.begins(9.0, HERE, bumped=False)
    assert not recovery.begins(11.0, HERE, bumped=False)
    assert not recovery.begins(13.0, HERE, bumped=False)
    assert recovery.begins(13.2, HERE, bumped=False)


def test_the_place_ahead():
    assert place_ahead(Pose2(1.0, 2.0, 3.14159265358979 / 2.0), 0.5) == pytest.approx((1.0, 2.5))


def test_standing_before_what_is_in_plain_sight_it_backs_off_sooner_and_to_both_sides():
    recovery = watching()
    turns, blamed = [], []
    for begun_s in (0.0, 10.0, 50.0):
        told = [recovery.blocked(begun_s + 0.2 * tick, 0.0, 0.0) for tick in range(9)]
        blamed.append(any(told))
        assert recovery.active
        turns.append(recovery.velocities(begun_s + 1.8)[1])
        recovery.velocities(begun_s + 5.0)
    assert turns[0] == -turns[1] == turns[2]
    assert blamed == [False, True, False]  # soon after the first time the place is to blame
    assert not recovery.keeps_failing


@pytest.mark.parametrize("velocities", [(0.2, 0.0), (0.0, 0.5)])
def test_driving_and_turning_is_not_standing(velocities):
    recovery = watching()
    for tick in range(60):
        recovery.blocked(0.2 * tick, *velocities)
    assert not recovery.active
