"""Where one is by what one hears: exact without noise, honest with it, and open where it is open."""

from math import exp, hypot, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import RadioConfig
from robots.estimation.radio.hearing import Ears, NodePlace
from robots.estimation.radio.locating import Heard, Plan, Radio, Since, locate
from robots.estimation.radio.model import RadioModel

EXACT = Radio(0.0, 0.0, 60.0)
ROOM = Plan(np.ones((20, 20), np.uint8), (0.0, 0.0), 1.0)


def metres(nodes, truth, sd_m, off=None):
    off = np.zeros(len(nodes)) if off is None else off
    return [
        Heard(f"n{k}", x, y, 0.0, max(hypot(x - truth[0], y - truth[1]) + e, 0.0), 0.0, sd_m)
        for k, ((x, y), e) in enumerate(zip(nodes, off, strict=True))
    ]


coordinates = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))


@settings(max_examples=40)
@given(truth=coordinates, turn=st.floats(0.0, 6.3), by_signal=st.booleans())
def test_three_nodes_without_noise_tell_the_very_place(truth, turn, by_signal):
    """Nodes all round, wherever that is; by signal of a receiver whose gain is known."""
    nodes = [(12.0 * np.cos(turn + a), 12.0 * np.sin(turn + a)) for a in (0.0, 2.1, 4.2)]
    heard = metres(nodes, truth, 1e-3)
    if by_signal:
        heard = [Heard(h.node_id, h.x_m, h.y_m, 0.0, h.range_m, 1e-4) for h in heard]
    (place,) = locate(heard, EXACT).places
    assert (place.x_m, place.y_m) == pytest.approx(truth, abs=0.02)
    assert max(place.var_x, place.var_y) < 0.05**2
    assert (place.share, place.is_hollow) == (1.0, False)


def test_the_covariance_is_honest():
    """NEES over many places, nodes and errors: of signals with a gain that nobody knows, and of metres."""
    for by_signal in (True, False):
        nees, inside = [], 0
        for seed in range(120):
            rng = np.random.default_rng(seed)
            nodes, truth = rng.uniform(0.0, 20.0, (int(rng.integers(4, 8)), 2)), rng.uniform(0.0, 20.0, 2)
            gain, heard = 0.2 * rng.normal(), []
            for k, node in enumerate(nodes):
                (x, y), far = node + 0.2 * rng.normal(size=2), float(np.hypot(*(node - truth)))
                if by_signal:
                    heard.append(Heard(f"n{k}", x, y, 0.2, far * exp(gain + 0.2 * rng.normal()), 0.2))
                else:
                    heard.append(Heard(f"n{k}", x, y, 0.2, max(0.0, far + 0.5 * rng.normal()), 0.0, 0.5))
            found = locate(heard, Radio(0.2, 0.0, 60.0), None, ROOM)
            off = []
            for place in found.places:
                error = np.array([place.x_m, place.y_m]) - truth
                spread = np.array([[place.var_x, place.var_xy], [place.var_xy, place.var_y]])
                off.append(float(error @ np.linalg.solve(spread, error)))
            inside += min(off) < 5.99
            if len(off) == 1:
                nees.append(min(off[0], 25.0))
        assert inside / 120 > 0.89  # 0.95 less three deviations
        assert 1.5 < np.mean(nees) < 2.4  # of 2; two dimensions


def test_two_nodes_leave_two_places_and_a_third_rules_one_out():
    nodes, truth = [(0.0, 0.0), (10.0, 0.0)], (4.0, 3.0)
    found = locate(metres(nodes, truth, 0.2), EXACT)
    assert sorted(round(place.y_m) for place in found.places) == [-3, 3]
    assert [place.share for place in found.places] == pytest.approx([0.5, 0.5], abs=1e-6)
    assert all(place.x_m == pytest.approx(4.0, abs=0.1) for place in found.places)
    (place,) = locate(metres([*nodes, (5.0, 6.0)], truth, 0.2), EXACT).places
    assert (place.x_m, place.y_m) == pytest.approx(truth, abs=0.1)


def test_the_plan_and_the_last_tag_rule_out_the_mirrored_place():
    nodes, truth = [(2.0, 5.0), (12.0, 5.0)], (6.0, 8.0)
    heard = metres(nodes, truth, 0.2)
    classes = np.ones((12, 16), np.uint8)
    classes[:4] = 0  # nobody has looked to the south of the corridor
    unseen = locate(heard, EXACT, None, Plan(classes, (0.0, 0.0), 1.0))
    assert unseen.places[0].share > 0.9
    assert unseen.places[0].y_m == pytest.approx(8.0, abs=0.2)
    (near,) = locate(heard, EXACT, Since(6.0, 10.0, 0.3, 3.0)).places
    assert near.y_m == pytest.approx(8.0, abs=0.2)


def test_a_wall_tells_by_what_it_takes():
    """Behind a wall a signal is weaker: the side on which it would be explained is the likely one."""
    nodes, truth = [(2.0, 5.0), (12.0, 5.0)], (6.0, 8.0)
    classes = np.ones((12, 16), np.uint8)
    classes[6] = 2
    radio = Radio(0.0, 0.6, 60.0)
    heard = [
        Heard(h.node_id, h.x_m, h.y_m, 0.0, h.range_m * exp(0.6), 0.1) for h in metres(nodes, truth, 0.2)
    ]
    place = locate(heard, radio, None, Plan(classes, (0.0, 0.0), 1.0)).places[0]
    assert place.share > 0.7
    assert place.x_m == pytest.approx(6.0, abs=0.4)
    assert 7.0 < place.y_m < 8.0 + 2.0 * place.var_y**0.5  # a wall may take more than it should: farther off


def test_one_node_is_a_ring():
    found = locate(metres([(1.0, 2.0)], (4.0, 6.0), 0.3), EXACT)
    assert (found.places, found.ring.node_id) == ((), "n0")
    assert (found.ring.range_m, found.ring.sd_m) == pytest.approx((5.0, 0.3))
    far = locate([Heard("n0", 0.0, 0.0, 0.0, 8.0, 0.4)], Radio(0.4, 0.2, 35.0)).ring
    assert 8.0 < far.range_m < 16.0
    assert far.sd_m > 2.0
    (place,) = locate(metres([(1.0, 2.0)], (4.0, 6.0), 0.3), EXACT, Since(1.0, 2.0, 0.5, 30.0)).places
    assert place.is_hollow
    assert (place.x_m, place.y_m) == pytest.approx((1.0, 2.0), abs=0.1)


def test_a_node_that_contradicts_all_others_is_left_out_and_a_contradiction_is_said():
    nodes, truth = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (5.0, 12.0)], (4.0, 3.0)
    moved = locate(metres(nodes, truth, 0.2, [0.0, 0.0, 0.0, 8.0, 0.0]), EXACT)
    assert (moved.left_out, moved.fits) == ("n3", True)
    assert (moved.places[0].x_m, moved.places[0].y_m) == pytest.approx(truth, abs=0.1)
    apart = locate(metres(nodes[:2], truth, 0.2, [-4.0, -4.0]), EXACT)
    assert not apart.fits
    assert apart.places[0].var_x > locate(metres(nodes[:2], truth, 0.2), EXACT).places[0].var_x


def test_nothing_and_no_number_are_refused():
    with pytest.raises(ValueError, match="nothing was heard"):
        locate([], EXACT)
    for bad in (Heard("n", nan, 0.0, 0.0, 1.0, 0.1), Heard("n", 0.0, 0.0, 0.0, nan, 0.1)):
        with pytest.raises(ValueError, match="finite"):
            locate([bad], EXACT)
    node = NodePlace("n", 0.0, 0.0, 0.1)
    for signals in ([nan], [nan, -40.0]):
        with pytest.raises(ValueError, match="finite"):
            Ears().by_signal(node, signals)


@settings(max_examples=40)
@given(st.lists(st.tuples(coordinates, st.floats(0.0, 1e3), st.booleans()), min_size=1, max_size=15))
def test_whatever_is_heard_the_answer_is_finite(readings):
    heard = [
        Heard(f"n{k}", x, y, 0.1, far, 0.4 if log else 0.0, 0.0 if log else 0.2)
        for k, ((x, y), far, log) in enumerate(readings)
    ]
    found = locate(heard, Radio(0.3, 0.2, 35.0), None, ROOM)
    assert found.places or found.ring
    for place in found.places:
        assert np.isfinite([place.x_m, place.y_m, place.var_x, place.var_xy, place.var_y]).all()
        assert min(place.var_x, place.var_y) >= 0.0
    assert sum(place.share for place in found.places) <= 1.0 + 1e-9


def test_signals_become_ranges_by_the_robots_model():
    radio = RadioConfig(power_at_1m_dbm=-40.0, path_loss_exponent=2.5, shadowing_sd_db=3.0)
    ears, model = Ears(radio, scale=1.1, offsets_m={"n": 0.4}), RadioModel(radio)
    node = NodePlace("n", 1.0, 2.0, 0.1)
    heard = ears.by_signal(node, [-60.0] * 5 + [-20.0])  # the last is a spike
    assert heard.range_m == pytest.approx(model.distance_m(-60.0))  # what robots learnt of ranges holds walls
    per_db = model.log_sd(5.0) / np.hypot(3.0, radio.fading_sd_db)
    assert heard.log_sd == pytest.approx(per_db * radio.fading_sd_db / 5**0.5)
    assert ears.shared.shadow_sds == pytest.approx((3.0 * per_db,))  # it stays, however often one listens
    assert ears.by_signal(node, [-60.0, -30.0, -90.0]) is None
    assert ears.by_range(node, [5.9, 5.9, 40.0]).range_m == pytest.approx(5.0)
