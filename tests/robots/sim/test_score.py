import numpy as np
import pytest

from robots.sim.rays import cast
from robots.sim.score import CoverageLog, found, observable, score
from robots.sim.world import World


def test_observable_against_brute_force(draw):
    world = draw(
        """
        ####################
        #........#.........#
        #........#....##...#
        #.............##...#
        #..####......####..#
        #..#..#............#
        #..####............#
        ####################
        """,
        resolution_m=0.25,
    )
    radius, reach = 0.2, 1.6
    expected = np.zeros_like(world.cells)
    for row, column in np.argwhere(world.reachable(radius)):
        cast(world, *world.centre(row, column), np.linspace(0, 2 * np.pi, 2001), reach, seen=expected)
    cells = observable(world, radius, reach)
    assert not cells[2, 4:6].any()  # the closet nobody gets into
    assert (cells != ((expected > 0) & world.free)).sum() <= 0.02 * cells.sum()


def test_coverage_is_seen_of_observable(hall):
    everything = observable(hall, 0.22, 4.0)
    assert everything.sum() == hall.free.sum()
    seen = np.zeros_like(hall.cells)
    seen[:, :101] = 1
    result = score(hall, seen, everything, 25.0, np.zeros((0, 2)), np.array([[1.0, 1.0]]))
    assert result.observable_m2 == pytest.approx(60.0)
    assert result.explored_m2 == pytest.approx(30.0)
    assert result.coverage == pytest.approx(0.5)
    assert result.score_m == pytest.approx(1.2)
    assert (result.victims_found, result.victims_total) == (0, 1)


def test_standing_still_scores_nothing(hall):
    nothing = np.zeros_like(hall.cells)
    assert score(hall, nothing, hall.free, 0.0, np.zeros((0, 2)), np.zeros((0, 2))).score_m == 0.0


def test_a_victim_is_found_once_and_within_a_metre():
    victims = np.array([[0.0, 0.0], [5.0, 5.0]])
    assert found(np.array([[0.9, 0.0], [0.0, 0.9], [5.0, 6.1]]), victims) == 1
    assert found(np.zeros((0, 2)), victims) == 0


def test_a_world_without_light_has_no_coverage(hall: World):
    dark = np.zeros(hall.cells.shape, dtype=bool)
    assert (
        score(hall, np.ones_like(hall.cells), dark, 1.0, np.zeros((0, 2)), np.zeros((0, 2))).coverage == 0.0
    )


def test_the_log_of_coverage_tells_when_a_share_was_reached():
    everything = np.ones((10, 10), bool)
    log, seen = CoverageLog(everything), np.zeros((10, 10), np.uint8)
    for second in range(1, 9):
        seen[second] = 1
        log.note(float(second), seen)
        log.note(second + 0.5, np.ones_like(seen))  # within the second: left out
    assert [log.reached_s(share) for share in (0.0, 0.1, 0.15, 0.8, 0.9)] == [1.0, 1.0, 2.0, 8.0, None]
