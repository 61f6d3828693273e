"""What a reader reports becomes a range, a bearing where there is one, and how far off they may be."""

from dataclasses import replace
from math import pi, radians

import pytest

from robots.config import AgentConfig
from robots.estimation.radio.model import UHF, RadioModel
from robots.estimation.radio.ranging import Ranging, seen_from_anchor
from robots.se2 import GaussianPose, Pose2
from robots.types import TagSighting

CONFIG = AgentConfig()


def test_a_measured_range_stays_as_it_was_measured():
    seen = Ranging(CONFIG).range(TagSighting("A", b"", 3.0, 0.5), 7.0, 0.0)
    assert (seen.tag_id, seen.stamp_s, seen.range_m, seen.bearing_rad) == ("A", 7.0, 3.0, 0.5)
    assert seen.range_sd_m == pytest.approx(CONFIG.ranging.range_sd_m + 3.0 * CONFIG.ranging.range_sd_per_m)
    alone = Ranging(CONFIG).range(TagSighting("A", b"", 3.0), 7.0, 0.0)
    assert alone.bearing_rad is None
    assert alone.bearing_sd_rad is None


def test_ten_signals_tell_a_range_and_then_the_robot_has_to_drive_on():
    ranging, signal = Ranging(CONFIG), RadioModel(CONFIG.radio).signal_dbm(8.0)
    told = [ranging.range(TagSighting("A", rssi_dbm=signal), 0.1 * k, 0.0) for k in range(40)]
    assert [k for k, seen in enumerate(told) if seen is not None] == [9]
    assert abs(told[9].range_m - 8.0) < told[9].range_sd_m
    onwards = [ranging.range(TagSighting("A", rssi_dbm=signal), 4.0, 0.6) for _ in range(10)]
    assert sum(seen is not None for seen in onwards) == 1


@pytest.mark.parametrize(("antenna", "heading"), [("front", 0.0), ("rear", pi)])
def test_a_directional_antenna_tells_its_side_and_no_more(antenna, heading):
    config = replace(CONFIG, radio=UHF)
    signal = RadioModel(UHF).signal_dbm(2.0)
    ranging = Ranging(config)
    (seen,) = [
        each
        for k in range(10)
        if (each := ranging.range(TagSighting("A", rssi_dbm=signal, antenna=antenna), k, 0.0)) is not None
    ]
    assert seen.base_from_antenna.theta == heading
    assert seen.bearing_rad == 0.0
    assert radians(15.0) < seen.bearing_sd_rad < radians(20.0)


def test_a_tag_under_the_antenna_has_no_range_and_a_signal_has_to_be_one():
    assert Ranging(CONFIG).range(TagSighting("A"), 0.0, 0.0) is None
    with pytest.raises(ValueError, match="finite"):
        Ranging(CONFIG).range(TagSighting("A", rssi_dbm=float("inf")), 0.0, 0.0)


def test_a_place_seen_from_a_pose_that_is_uncertain_is_more_uncertain():
    sighting = TagSighting("A", b"", 2.0, pi / 2)
    sure = GaussianPose.exact()
    place, spread = seen_from_anchor(sighting, sure, CONFIG)
    assert place == pytest.approx((0.0, 2.0))
    here = Pose2(1.0, 0.0, pi / 2)
    loose = GaussianPose(here, sure.covariance + 0.01 * (sure.covariance == sure.covariance.T))
    moved, wider = seen_from_anchor(sighting, GaussianPose(here, loose.covariance), CONFIG)
    assert moved == pytest.approx((-1.0, 0.0))
    assert wider.trace() > spread.trace()


def test_a_mean_of_signals_belongs_to_the_middle_of_where_they_were_read():
    ranging, signal = Ranging(CONFIG), RadioModel(CONFIG.radio).signal_dbm(8.0)
    poses = [Pose2(0.04 * k, 0.0, 0.0) for k in range(CONFIG.radio.readings)]
    told = [
        ranging.range(TagSighting("A", rssi_dbm=signal), 0.1 * k, pose.x, pose)
        for k, pose in enumerate(poses)
    ]
    mean = next(each for each in told if each is not None)
    assert mean.base_from_antenna.x == pytest.approx(-poses[-1].x / 2.0)
