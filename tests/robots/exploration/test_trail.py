"""What is noted of a robot's way."""

import numpy as np

from robots.exploration.trail import Trail, rest_of
from robots.se2 import Pose2


def test_a_trail_has_a_point_each_quarter_of_a_metre_with_its_stamp():
    trail = Trail()
    assert trail.points.shape == (0, 4)
    for k in range(11):
        trail.note(float(k), Pose2(0.1 * k, 0.0, 0.5))
    np.testing.assert_allclose(trail.points, [[x, 0.0, 0.5, 10 * x] for x in (0.0, 0.3, 0.6, 0.9)])


def test_the_rest_of_a_way_begins_where_the_robot_is():
    path = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    np.testing.assert_array_equal(rest_of(path, Pose2(1.8, 0.3, 0.0)), path[2:])
    assert rest_of(path[:0], Pose2()).shape == (0, 2)
