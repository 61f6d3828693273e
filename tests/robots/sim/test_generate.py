import numpy as np
import pytest
from scipy import ndimage

from robots.sim.generate import generate
from robots.sim.world import WorldError


@pytest.mark.parametrize("kind", ["office", "open"])
@pytest.mark.parametrize("area_m2", [40.0, 120.0, 300.0, 590.0])
@pytest.mark.parametrize("seed", range(4))
def test_area_and_connection(kind, area_m2, seed):
    world = generate(kind, area_m2, np.random.default_rng(seed))
    assert world.free_area_m2 == pytest.approx(area_m2, rel=0.03)
    assert ndimage.label(world.free)[1] == 1
    reachable = world.reachable(0.22)  # the default body gets about
    near = ndimage.distance_transform_edt(~reachable) * world.resolution_m < 0.45
    assert (near & world.free).sum() > 0.99 * world.free.sum()


def test_the_seed_decides():
    one, same, other = (generate("office", 200.0, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert np.array_equal(one.cells, same.cells)
    assert one.cells.shape != other.cells.shape or not np.array_equal(one.cells, other.cells)


def test_an_office_has_rooms_behind_doors():
    """Closing gaps as wide as a door cuts an office into rooms, and a hall not at all."""
    parts = {}
    for kind in ("office", "open"):
        world = generate(kind, 590.0, np.random.default_rng(5))
        labels, _ = ndimage.label(world.clearance_m > 0.62)
        parts[kind] = int((np.bincount(labels.ravel())[1:] * world.resolution_m**2 > 2.0).sum())
    assert parts["office"] >= 12
    assert parts["open"] == 1


@pytest.mark.parametrize(
    ("kind", "area_m2"), [("office", 5.0), ("open", 1e6), ("castle", 100.0), ("open", np.nan)]
)
def test_what_cannot_be_built(kind, area_m2):
    with pytest.raises(WorldError, match=r"out of range|no 'castle' worlds"):
        generate(kind, area_m2, np.random.default_rng(0))
