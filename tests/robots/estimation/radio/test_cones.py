"""Tags that come into a cone or leave it tell where its edge is, and corners do not."""

from math import atan2, hypot, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import AgentConfig
from robots.estimation.ekf.filter import EkfFilter
from robots.estimation.radio.cones import EDGE_SD_RAD, ConeWatch, Crossing, Expected, edge_of
from robots.estimation.radio.model import UHF, RadioModel
from robots.estimation.tag_filter import Dropped, RangeSighting
from robots.se2 import GaussianPose, Pose2, wrap
from robots.types import TagSighting

HALF, STEP_S = radians(30.0), 0.05


def _bearing(base_from_antenna, base, tag):
    antenna = base @ base_from_antenna
    return wrap(atan2(tag[1] - antenna.y, tag[0] - antenna.x) - antenna.theta)


def _heard(base, tags):
    heard = []
    for name, tag in tags.items():
        for antenna in ("front", "rear"):
            direction = RadioModel(UHF).direction(antenna)
            place = base @ direction.base_from_antenna
            near = hypot(tag[0] - place.x, tag[1] - place.y) < UHF.reach_m
            if near and abs(_bearing(direction.base_from_antenna, base, tag)) < HALF:
                heard.append(TagSighting(name, rssi_dbm=-40.0, antenna=antenna))
    return tuple(heard)


def _watched(poses, tags):
    watch, found = ConeWatch(RadioModel(UHF)), []
    for k, pose in enumerate(poses):
        for crossing in watch.watch(k * STEP_S, pose, _heard(pose, tags)):
            found.append((pose, crossing))
    return found


@settings(max_examples=30, deadline=None)
@given(st.floats(0.4, 1.2), st.sampled_from((1.0, -1.0)), st.floats(-3.0, 3.0))
def test_a_tag_that_is_driven_past_crosses_two_edges(aside, side, turn):
    """Out of the front cone, into the rear one: each bearing is the edge, to what was driven meanwhile."""
    start = Pose2(1.0, 2.0, turn)
    tag = start.transform_point(3.0, side * aside)
    poses = [start @ Pose2(0.02 * k, 0.0, 0.0) for k in range(320)]
    others = {f"way-{k}": start.transform_point(float(k), 0.0) for k in range(-3, 12)}
    found = [each for each in _watched(poses, {"T": tag, **others}) if each[1].tag_id == "T"]
    assert [crossing.outward for _, crossing in found][:2] == [True, False]
    for here, crossing in found[:2]:
        bearing = _bearing(crossing.base_from_middle, here, tag)
        assert abs(abs(bearing) - HALF) < 0.03 / aside
        expected = [
            Expected(2.0 * aside, _bearing(pose, here, tag), 0.01, 0.01)
            for pose in (crossing.base_from_first, crossing.base_from_middle, crossing.base_from_last)
        ]
        edge, variance = edge_of(crossing, *expected)
        assert abs(edge) == pytest.approx(HALF)
        assert np.sign(edge) == np.sign(bearing)
        assert variance >= EDGE_SD_RAD**2


def test_a_robot_that_stands_still_hears_no_crossing():
    assert not _watched([Pose2()] * 200, {"T": (2.0, 0.1), "S": (3.0, -0.2)})


def test_a_radio_that_pauses_does_not_cross_all_tags():
    watch, pose = ConeWatch(RadioModel(UHF)), Pose2()
    heard = _heard(pose, {"T": (2.0, 0.1), "S": (3.0, -0.2)})
    for k in range(400):
        assert not watch.watch(k * STEP_S, pose, () if 100 < k < 300 else heard)


def test_readings_without_an_antenna_and_a_clock_that_stands_tell_nothing():
    watch = ConeWatch(RadioModel(UHF))
    for k in range(100):
        readings = (TagSighting("T", rssi_dbm=-40.0), TagSighting("U"))
        assert not watch.watch(k * STEP_S, Pose2(), readings)
        assert not watch.watch(0.0, Pose2(), ())


def _crossing(outward=True):
    return Crossing("T", Pose2(), Pose2(), Pose2(), outward, HALF, 4.0)


def _sweep(middle, swept, range_m=2.0, sd=0.05):
    return [Expected(range_m, middle + share * swept, 0.01, sd**2) for share in (-0.5, 0.0, 0.5)]


def test_what_is_no_edge_tells_no_bearing():
    assert edge_of(_crossing(), *_sweep(HALF, 0.1)) is not None
    assert edge_of(_crossing(), *_sweep(HALF, -0.1)) is None  # it moved inwards and fell silent
    assert edge_of(_crossing(False), *_sweep(HALF, 0.1)) is None
    assert edge_of(_crossing(), *_sweep(0.1, 0.1)) is None  # in the middle of the cone: a corner
    assert edge_of(_crossing(), *_sweep(HALF, 0.1, range_m=3.9)) is None  # out of reach
    assert edge_of(_crossing(), *_sweep(HALF, 0.1, range_m=0.1)) is None
    assert edge_of(_crossing(), *_sweep(HALF, pi)) is None  # turned past too fast
    assert edge_of(_crossing(), *_sweep(HALF, 0.1, sd=0.6)) is None  # either edge


def test_doubt_whether_it_was_the_edge_makes_the_bearing_less_certain():
    sure, doubtful = (edge_of(_crossing(), *_sweep(HALF - off, 0.05))[1] for off in (0.0, 0.15))
    assert doubtful > sure


def test_a_crossing_places_the_tag_in_its_direction():
    """A tag known to half a metre across is known to a fifth of that, where it is, after one crossing."""
    tag_filter = EkfFilter("r1", AgentConfig(), Pose2())
    true_bearing = HALF
    tag = 2.0 * np.array([np.cos(true_bearing), np.sin(true_bearing)])
    dropped = Dropped((tag[0] - 0.1, tag[1] + 0.2), 0.3**2 * np.eye(2))
    tag_filter.see(RangeSighting("T", 0.0, 2.0, 0.05, dropped=dropped))
    first, last = Pose2(0.0, 0.0, 0.03), Pose2(0.0, 0.0, -0.03)
    tag_filter.see_crossing(Crossing("T", first, Pose2(), last, True, HALF, 4.0))
    belief = tag_filter.tags()["T"]
    across = np.array([-np.sin(true_bearing), np.cos(true_bearing)])
    off = across @ (belief.x_m - tag[0], belief.y_m - tag[1])
    covariance = np.array(
        [[belief.variance_x, belief.covariance_xy], [belief.covariance_xy, belief.variance_y]]
    )
    sd = np.sqrt(across @ covariance @ across)
    assert abs(off) < 0.1
    assert sd < 0.2
    tag_filter.predict(GaussianPose(Pose2(0.1, 0.0, 0.0), 1e-6 * np.eye(3)))
    tag_filter.see_crossing(Crossing("unknown", first, Pose2(), last, True, HALF, 4.0))  # is left out
    assert set(tag_filter.tags()) == {"T"}
