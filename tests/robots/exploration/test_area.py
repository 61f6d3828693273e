"""Whether a point lies in an area that somebody drew."""

from math import atan2, cos, pi, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.exploration.area import holds

L_SHAPE = ((0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (2.0, 2.0), (2.0, 6.0), (0.0, 6.0))
NUMBER = st.floats(-10.0, 10.0)


@given(st.lists(st.tuples(NUMBER, NUMBER), min_size=3, max_size=8), NUMBER, NUMBER)
def test_a_point_is_inside_where_the_corners_go_round_it(corners, x, y):
    """The even-odd rule is the parity of the winding number, found by adding up angles."""
    around = [np.array(corner) - (x, y) for corner in corners]
    if min(abs(dx) + abs(dy) for dx, dy in around) < 1e-6:
        return  # on a corner, where either answer is right
    turned = [
        atan2(a[0] * b[1] - a[1] * b[0], a @ b) for a, b in zip(around, around[1:] + around[:1], strict=True)
    ]
    winding = sum(turned) / (2 * pi)
    if any(abs(abs(turn) - pi) < 1e-6 for turn in turned) or abs(winding - round(winding)) > 1e-6:
        return  # on a side, where either answer is right
    assert holds(tuple(corners), x, y) == (round(winding) % 2 == 1)


def test_it_may_be_bent_inwards_and_has_a_rim():
    assert holds(L_SHAPE, 1.0, 5.0)
    assert not holds(L_SHAPE, 4.0, 4.0)
    assert holds(L_SHAPE, 2.5, 4.0, rim_m=0.6)
    assert not holds(L_SHAPE, 2.5, 4.0, rim_m=0.4)
    around = [(3.0 + 9.0 * cos(a), 3.0 + 9.0 * sin(a)) for a in np.linspace(0, 2 * pi, 20)]
    assert not any(holds(L_SHAPE, *point, rim_m=1.0) for point in around)
