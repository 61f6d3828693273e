import numpy as np
import pytest

from robots.sim.body import inside_solid
from robots.sim.generate import generate
from robots.sim.starts import place_robots, place_victims
from robots.sim.world import WorldError

RADIUS = 0.22


def gaps(places: np.ndarray) -> np.ndarray:
    distances = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    return distances[np.triu_indices(len(places), 1)]


@pytest.mark.parametrize("kind", ["same", "spread"])
@pytest.mark.parametrize("robots", [1, 4, 12])
@pytest.mark.parametrize("seed", [0, 1])
def test_robots_stand_free_and_apart(kind, robots, seed):
    world = generate("office", 150.0, np.random.default_rng(seed))
    starts = place_robots(world, robots, RADIUS, kind, np.random.default_rng(seed))
    assert starts.shape == (robots, 3)
    assert not any(inside_solid(world, x, y, RADIUS + 0.03) for x, y, _ in starts)
    reachable = world.reachable(RADIUS)
    assert all(reachable[world.cell(x, y)] for x, y, _ in starts)
    if robots > 1:
        assert gaps(starts[:, :2]).min() >= 2 * RADIUS + 0.099
        if kind == "same":
            assert gaps(starts[:, :2]).min() >= 0.599
            assert len(set(starts[:, 2])) == 1


def test_spread_is_wider_than_same():
    world = generate("office", 300.0, np.random.default_rng(1))
    same, spread = (
        place_robots(world, 4, RADIUS, kind, np.random.default_rng(1)) for kind in ("same", "spread")
    )
    assert gaps(same[:, :2]).max() < 3.0 < gaps(spread[:, :2]).min()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_victims_lie_by_walls_apart_and_reachable(seed):
    world = generate("office", 200.0, np.random.default_rng(seed))
    robots = place_robots(world, 4, RADIUS, "same", np.random.default_rng(seed))[:, :2]
    victims = place_victims(world, 6, RADIUS, robots, np.random.default_rng(seed))
    places = np.array([(victim.x_m, victim.y_m) for victim in victims])
    assert [victim.victim_id for victim in victims] == ["V1", "V2", "V3", "V4", "V5", "V6"]
    assert gaps(places).min() >= 1.5
    assert np.hypot(*(places[:, None] - robots[None]).transpose(2, 0, 1)).min() >= 3.0
    reachable = world.reachable(RADIUS)
    for x, y in places:
        cell = world.cell(x, y)
        assert reachable[cell]
        assert world.clearance_m[cell] <= RADIUS + 0.36


def test_too_many_is_an_error_that_says_so():
    world = generate("open", 30.0, np.random.default_rng(0))
    with pytest.raises(WorldError, match="no room for 90 robots"):
        place_robots(world, 90, RADIUS, "same", np.random.default_rng(0))
    with pytest.raises(WorldError, match="no room for 300 robots"):
        place_robots(world, 300, RADIUS, "spread", np.random.default_rng(0))
    with pytest.raises(WorldError, match="no room for 500 victims"):
        place_victims(world, 500, RADIUS, np.zeros((0, 2)), np.random.default_rng(0))
