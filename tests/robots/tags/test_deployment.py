"""Where tags are dropped: rather where there are none, between walls, and never from an empty magazine."""

from math import exp, pi

import numpy as np
import pytest

from robots.config import DeploymentConfig, MappingConfig
from robots.mapping.fused import FusedGrid
from robots.se2 import Pose2
from robots.tags.deployment import TagDropper, side_density, tag_density

CONFIG, MAPPING = DeploymentConfig(), MappingConfig()
HERE = Pose2(0.0, 0.0, 0.0)
SEEDS = range(400)


def corridor(left: bool, right: bool, heading: float = 0.0) -> FusedGrid:
    """Free ground, and a wall 0.9 m to the left and to the right of a robot at the origin where asked for."""
    cells = np.full((60, 60), -20, np.int16)
    if left:
        cells[48, :] = 40
    if right:
        cells[12, :] = 40
    fused = FusedGrid(0.05)
    fused.put("map", 0, Pose2(0.0, 0.0, heading) @ Pose2(-1.5, -1.5), cells)
    return fused


OPEN, NARROW = corridor(False, False), corridor(True, True)


def drops(fused: FusedGrid, tags=(), pose=HERE, moved=1.0, config=CONFIG) -> set[int]:
    """Seeds that drop a tag within one stretch of way."""
    return {s for s in SEEDS if TagDropper(config, MAPPING, s).should_drop(moved, pose, fused, tags)}


def drive(dropper: TagDropper, fused: FusedGrid, metres: float, tags: list[tuple[float, float]]) -> list[int]:
    """Drive along x in steps of 0.11 m, dropping as it likes; the numbers of the steps with a drop."""
    dropped = []
    for step in range(round(metres / 0.11)):
        dropper.magazine(None, 0.2 * step)
        if dropper.should_drop(0.11 * step, HERE, fused, tags):
            dropped.append(step)
    return dropped


def test_tag_density_is_one_at_a_tag_and_adds_up():
    assert tag_density(1.0, 2.0, [(1.0, 2.0)], 4.0) == pytest.approx(1.0)
    assert tag_density(1.0, 2.0, [(1.0, 6.0)], 4.0) == pytest.approx(exp(-2.0))
    assert tag_density(0.0, 0.0, [(1.0, 0.0), (0.0, 1.0)], 4.0) == pytest.approx(2.0 * exp(-2.0 / 16.0))
    assert tag_density(0.0, 0.0, [], 4.0) == 0.0


@pytest.mark.parametrize(
    ("left", "right", "density"),
    [(True, True, 1.0), (True, False, 0.0), (False, True, 0.0), (False, False, 0.0)],
)
@pytest.mark.parametrize("heading", [0.0, 1.1, -2.6, pi])
def test_only_walls_on_both_sides_count(left, right, density, heading):
    pose = Pose2(0.0, 0.0, heading)
    fused = corridor(left, right, heading)
    assert side_density(pose, fused, CONFIG.side_window_m, MAPPING.occupied_logodds) == density


def test_walls_ahead_and_beyond_the_window_do_not_count():
    across = Pose2(0.0, 0.0, pi / 2.0)
    assert side_density(across, NARROW, CONFIG.side_window_m, MAPPING.occupied_logodds) == 0.0
    assert side_density(HERE, NARROW, 0.8, MAPPING.occupied_logodds) == 0.0


def test_a_wall_that_ends_beside_the_robot_counts_in_part():
    cells = np.full((60, 60), -20, np.int16)
    cells[48, :31] = cells[12, :31] = 40  # up to x = 0.05
    fused = FusedGrid(0.05)
    fused.put("map", 0, Pose2(-1.5, -1.5), cells)
    assert side_density(HERE, fused, CONFIG.side_window_m, MAPPING.occupied_logodds) == pytest.approx(0.36)


def test_in_the_open_and_in_a_corridor_the_share_of_drops_is_the_rate_of_the_paper():
    for fused, sides in ((OPEN, 0.12), (NARROW, 1.0)):
        expected = 1.0 - exp(-CONFIG.rate_per_m * sides)
        share = len(drops(fused)) / len(SEEDS)
        assert share == pytest.approx(expected, abs=4.0 * (expected * (1.0 - expected) / len(SEEDS)) ** 0.5)


def test_obstacles_on_both_sides_mean_more_drops_for_every_seed():
    assert drops(OPEN) < drops(corridor(True, True))
    assert drops(corridor(True, False)) == drops(OPEN)


def test_more_tags_near_mean_fewer_drops_for_every_seed():
    places = [(4.5, 0.0), (0.0, 4.2), (-4.0, 0.0), (0.5, 0.5)]
    found = [drops(NARROW, places[:count]) for count in range(len(places) + 1)]
    assert found[0] > found[1] > found[2] > found[3]
    assert found[4] == set()
    nearer = [drops(NARROW, [(distance, 0.0)]) for distance in (8.0, 4.0, 3.0, 0.0)]
    assert nearer[0] > nearer[1] > nearer[2] > nearer[3] == set()


def test_a_longer_way_means_more_drops_for_every_seed():
    assert drops(NARROW, moved=0.2) < drops(NARROW, moved=0.8) < drops(NARROW, moved=3.0)


def test_the_same_seed_drops_at_the_same_places():
    first, again, other = (drive(TagDropper(CONFIG, MAPPING, seed), NARROW, 30.0, []) for seed in (5, 5, 6))
    assert first == again != other
    assert len(first) > 5


def test_the_rate_does_not_depend_on_how_often_it_is_asked():
    def count(step: float) -> float:
        total = 0
        for seed in range(60):
            dropper = TagDropper(CONFIG, MAPPING, seed)
            total += sum(dropper.should_drop(step * k, HERE, OPEN, []) for k in range(round(20.0 / step)))
        return total / 60.0

    assert count(0.125) == pytest.approx(count(0.5), rel=0.2)


def test_the_magazine_runs_empty_and_stays_so():
    dropper = TagDropper(DeploymentConfig(magazine=3), MAPPING, 1)
    assert len(drive(dropper, NARROW, 60.0, [])) == 3
    assert dropper.left == 0
    assert drive(dropper, NARROW, 60.0, []) == []
    assert dropper.left == 0


def test_the_robots_own_count_is_taken_over_and_never_below_none():
    dropper = TagDropper(CONFIG, MAPPING, 1)
    dropper.magazine(None, 0.0)
    assert dropper.left == CONFIG.magazine
    dropper.magazine(2, 0.0)
    assert dropper.left == 2
    dropper.magazine(-4, 0.0)
    assert dropper.left == 0
    assert drive(dropper, NARROW, 30.0, []) == []


def test_after_a_drop_it_waits_until_the_tag_can_have_been_read():
    steps = drive(TagDropper(DeploymentConfig(rate_per_m=1e6), MAPPING, 0), NARROW, 10.0, [])
    assert len(steps) > 10
    assert np.diff(steps).min() * 0.11 >= 0.5


def test_standing_still_and_having_no_map_drop_nothing():
    eager = DeploymentConfig(rate_per_m=1e6)
    dropper = TagDropper(eager, MAPPING, 0)
    assert not any(dropper.should_drop(0.05, HERE, NARROW, []) for _ in range(100))
    assert not dropper.should_drop(5.0, HERE, FusedGrid(0.05), [])
    assert dropper.should_drop(5.0, HERE, NARROW, [])


def test_evenly_it_drops_wherever_no_tag_is_near_and_only_there():
    config = DeploymentConfig(even_m=1.0)
    assert len(drops(OPEN, config=config)) == len(SEEDS)
    assert drops(OPEN, tags=[(0.9, 0.0)], config=config) == set()
    assert len(drops(OPEN, tags=[(1.1, 0.0)], config=config)) == len(SEEDS)


def test_a_tag_that_does_not_fall_is_told_of_and_tried_again_farther_and_farther_on():
    dropper, tried_m, told = TagDropper(DeploymentConfig(rate_per_m=1e6), MAPPING, 0), [], []
    for step in range(1000):
        driven_m = 0.11 * step
        told.append(dropper.magazine(5, 0.2 * step))
        if dropper.should_drop(driven_m, HERE, NARROW, []):
            assert not dropper.should_drop(driven_m + 0.2, HERE, NARROW, [])  # one at a time
            tried_m.append(driven_m)
    assert np.diff(tried_m) == pytest.approx([5.0, 10.0, 20.0, 40.0], abs=0.3)
    assert told.count("stuck") == len(tried_m) == 5
    assert "fell" not in told
    dropper.magazine(5, 300.0)
    assert dropper.drop_here(200.0)
    assert dropper.magazine(4, 300.2) == "fell"
    assert dropper.should_drop(201.0, HERE, NARROW, [])


def test_a_tag_has_a_moment_to_fall():
    dropper = TagDropper(DeploymentConfig(magazine=5), MAPPING, 0)
    assert dropper.drop_here(1.0)
    assert [dropper.magazine(5, now_s) for now_s in (0.0, 1.0, 2.5)] == [None] * 3
    assert dropper.magazine(4, 2.8) == "fell"
