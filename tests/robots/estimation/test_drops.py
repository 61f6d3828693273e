"""A tag that the robot dropped itself is placed where it was dropped, once, and only where that fits."""

from math import pi

import numpy as np
import pytest

from robots.config import AgentConfig
from robots.estimation.drops import Drops
from robots.estimation.radio.model import RadioModel, radio_for
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Pose2

RADIO = RadioModel(radio_for("uhf", "office2"))
DROPPED_AT = Pose2(1.0, 2.0, 0.4)


def heard(tag_id: str, antenna: str, away_m: float) -> RangeSighting:
    direction = RADIO.direction(antenna)
    told = RADIO.range_of(RADIO.signal_dbm(away_m), 10)
    return RangeSighting(
        tag_id,
        0.0,
        told.range_m,
        told.sd_m,
        direction.bearing_rad,
        direction.bearing_sd_rad,
        direction.base_from_antenna,
        told.median_m,
        told.log_sd,
    )


def after_a_drop() -> Drops:
    drops = Drops(AgentConfig())
    drops.follow(10, Pose2(), 0.0)
    drops.follow(9, DROPPED_AT, 2.5)
    return drops


def test_the_first_tag_heard_behind_lies_where_it_was_dropped():
    drops, here = after_a_drop(), DROPPED_AT @ Pose2(0.8, 0.0, 0.1)
    dropped = drops.place(heard("A", "rear", 0.6), here, 3.3)
    assert dropped is not None
    assert here.transform_point(*dropped.place_m) == pytest.approx((DROPPED_AT.x, DROPPED_AT.y))
    assert 0.01 < np.linalg.eigvalsh(dropped.covariance)[0] < 0.1
    assert drops.place(heard("B", "rear", 0.6), here, 3.3) is None  # one drop, one tag


@pytest.mark.parametrize(("antenna", "away_m"), [("front", 0.6), ("rear", 15.0)])
def test_a_tag_on_the_other_side_or_far_off_is_another_one(antenna, away_m):
    drops = after_a_drop()
    assert drops.place(heard("A", antenna, away_m), DROPPED_AT @ Pose2(0.8, 0.0, 0.0), 3.3) is None


def test_a_tag_heard_before_the_drop_is_another_one():
    drops = Drops(AgentConfig())
    drops.follow(10, Pose2(), 0.0)
    assert drops.place(heard("A", "rear", 0.6), DROPPED_AT, 2.4) is None
    drops.follow(9, DROPPED_AT, 2.5)
    assert drops.place(heard("A", "rear", 0.6), DROPPED_AT @ Pose2(0.8, 0.0, 0.0), 3.3) is None


def test_two_drops_that_both_fit_place_nothing():
    drops = after_a_drop()
    drops.follow(8, DROPPED_AT @ Pose2(0.3, 0.0, 0.0), 2.8)
    assert drops.place(heard("A", "rear", 0.7), DROPPED_AT @ Pose2(1.0, 0.0, 0.0), 3.5) is None


def test_a_drop_long_ago_and_a_magazine_filled_again_tell_nothing():
    drops = after_a_drop()
    drops.follow(9, DROPPED_AT @ Pose2(0.8, 0.0, pi), 30.0)
    assert drops.place(heard("A", "rear", 0.6), DROPPED_AT @ Pose2(0.8, 0.0, 0.0), 30.0) is None
    drops.follow(100, DROPPED_AT, 30.1)
    assert drops.place(heard("B", "rear", 0.6), DROPPED_AT @ Pose2(0.8, 0.0, 0.0), 30.9) is None
