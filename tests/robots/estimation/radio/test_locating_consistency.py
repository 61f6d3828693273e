"""Whether places by nodes hold what they claim: among walls that a map shows as robots see them.

The air is the simulator's, with its walls; the phone is told an exponent that may be wrong, a map of walls
with two faces, each drawn twice, and nodes that lie a little elsewhere.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from robots.estimation.radio.hearing import Ears, NodePlace
from robots.estimation.radio.likelihood import CELLS
from robots.estimation.radio.locating import Plan, _costs, _rows, locate
from robots.estimation.radio.model import NODE
from robots.estimation.radio.walls import UNSEEN, count_walls
from robots.sim.generate import generate
from robots.sim.hearing import Device
from robots.sim.tags import TagField

NODE_SD_M = 0.12
PLANS = (("office", 60.0, 5), ("office", 150.0, 9), ("open", 100.0, 6), ("open", 300.0, 10))
PLACES = 20  # of each plan


def as_seen(world, rng):
    """Return the plan that a laser leaves: faces of walls, drawn again up to 15 cm off, unknown within."""
    solid = world.cells != 0
    face = solid & ndimage.binary_dilation(~solid)
    down, across = rng.integers(-3, 4, 2)
    again = np.roll(face, (down, across), (0, 1)) & (rng.random(face.shape) < 0.5)
    classes = np.where(solid, 0, 1).astype(np.uint8)
    classes[face | again] = 2
    return Plan(classes, world.origin_m, world.resolution_m)


def asked(kind, area_m2, nodes, told):
    """Yield the true place and what is answered there, of one generated plan."""
    for truth, heard, ears, plan in listened(kind, area_m2, nodes, told, PLACES):
        yield truth, locate(heard, ears.shared, None, plan)


def listened(kind, area_m2, nodes, told, count):
    """Yield the true place, what is heard there, by what model, and the plan."""
    rng = np.random.default_rng([int(area_m2), nodes])
    world = generate(kind, area_m2, rng)
    plan = as_seen(world, rng)
    open_ground = np.argwhere(ndimage.binary_erosion(world.cells == 0, iterations=4))

    def somewhere():
        row, column = open_ground[rng.integers(len(open_ground))]
        x, y = world.origin_m
        return x + (column + 0.5) * world.resolution_m, y + (row + 0.5) * world.resolution_m

    field, places = TagField(2048), {}
    for number in range(nodes):
        x, y = somewhere()
        field.drop(f"N{number}", x, y)
        off_x, off_y = NODE_SD_M * rng.standard_normal(2)
        places[f"N{number}"] = NodePlace(f"N{number}", x + off_x, y + off_y, NODE_SD_M)
    ears = Ears(told)
    for seed in range(count):
        x, y = somewhere()
        signals: dict[str, list[float]] = {}
        for node_id, rssi_dbm in Device(world, field, NODE, seed).heard_at(x, y):
            signals.setdefault(node_id, []).append(rssi_dbm)
        heard = [ears.by_signal(places[node_id], rssis) for node_id, rssis in signals.items()]
        yield (x, y), [each for each in heard if each], ears, plan


def squares(truth, found):
    """The squared error over the claimed variance, of each place that is named."""
    for place in found.places:
        off = np.array([place.x_m, place.y_m]) - truth
        spread = np.array([[place.var_x, place.var_xy], [place.var_xy, place.var_y]])
        yield float(off @ np.linalg.solve(spread, off))


@pytest.mark.parametrize("wrong_by", [0.0, 0.4])
def test_two_deviations_hold_the_truth_among_walls_and_with_a_wrong_exponent(wrong_by):
    told = replace(NODE, path_loss_exponent=NODE.path_loss_exponent + wrong_by)
    nees, off_m = [], []
    for spec in PLANS:
        for truth, found in asked(*spec, told):
            nees.append(min(squares(truth, found)))
            best = found.places[0]
            off_m.append(np.hypot(best.x_m - truth[0], best.y_m - truth[1]))
    held = float(np.mean(np.array(nees) < 4.0))  # two deviations in the plane: 0.865 of a normal law
    assert 0.80 <= held <= 0.99
    assert 0.5 < np.median(nees) < 2.2  # 1.39
    assert np.median(off_m) < 1.2


def test_two_faces_of_a_wall_and_a_face_drawn_twice_are_one_wall():
    ground = np.zeros((1, 40), np.uint8)
    ground[0, [10, 11, 13, 20, 35]] = 1
    ground[0, 14:20] = UNSEEN
    for apart, walls in ((0.0, [0, 2, 3]), (4.0, [0, 1, 2])):
        assert [count_walls(ground, 0.5, 0.5, to, 0.5, 9, apart) for to in (9.5, 25.5, 39.5)] == walls


def test_what_is_answered_in_a_hall_of_debris_is_what_the_probabilities_say():
    """Mean and covariance against a grid of 20 cm: a peak at one side of a wall is not all there is."""
    off, sds = [], []
    for _, heard, ears, plan in listened("open", 200.0, 9, NODE, 12):
        found = locate(heard, ears.shared, None, plan)
        shares = np.array([place.share for place in found.places])
        means = np.array([(place.x_m, place.y_m) for place in found.places])
        spread = np.array([place.var_x + place.var_y for place in found.places])
        mean = shares @ means / shares.sum()
        total = shares @ (spread + ((means - mean) ** 2).sum(axis=1)) / shares.sum()
        there, variance = moments_by_grid(heard, ears, plan)
        off.append(np.hypot(*(mean - there)) / np.sqrt(variance / 2.0))
        sds.append(np.sqrt(total / variance))
    assert np.mean(np.array(off) < 0.3) > 0.9
    assert np.mean(np.array(sds) > 0.7) > 0.9  # what has no real share is left out


def moments_by_grid(heard, ears, plan):
    """Mean (2,) and the sum of both variances of the probability over the plan and 8 m about it."""
    size, low = 0.2, np.array(plan.origin_m) - 8.0
    high = low + 16.0 + np.array(plan.classes.shape[::-1]) * plan.resolution_m
    costs, places = [], []
    for x in np.arange(low[0], high[0], CELLS * size):
        for y in np.arange(low[1], high[1], CELLS * size):
            drawn = _costs(_rows(heard), ears.shared, None, plan, np.array([x, y, size, size]))
            rows, columns = np.indices(drawn.shape)
            costs.append(drawn.ravel())
            places.append(
                np.column_stack([x + (columns.ravel() + 0.5) * size, y + (rows.ravel() + 0.5) * size])
            )
    weights = np.exp(-0.5 * (np.concatenate(costs) - np.min(costs)))
    weights /= weights.sum()
    middles = np.concatenate(places)
    mean = weights @ middles
    return mean, float(weights @ ((middles - mean) ** 2).sum(axis=1))
