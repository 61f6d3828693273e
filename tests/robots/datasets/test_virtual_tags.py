"""Virtual tags: spacing, and one sighting a pass at its closest approach."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.datasets.virtual_tags import place_tags


def line(*x: float) -> np.ndarray:
    return np.array([[value, 0.0] for value in x])


def test_tags_stand_where_none_is_nearer_than_the_spacing():
    tags = place_tags(line(0.0, 0.9, 1.0, 1.9, 2.1, 0.0), 1.0)
    assert tags.places_m[:, 0].tolist() == [0.0, 1.0, 2.1]


def test_a_pass_is_read_once_at_its_closest_approach():
    # there and back over the tag at 0.5: the second pass is nearest at the frame at 0.45
    tags = place_tags(line(0.5, 0.55, 2.0, 0.62, 0.45, 0.36, -1.0), 100.0)
    assert tags.sighted == {0: (0,), 4: (0,)}


def test_outside_the_reach_of_the_reader_nothing_is_read():
    assert place_tags(line(0.0, 0.16, 1.0, 0.16), 100.0).sighted == {0: (0,)}


def test_frames_without_a_reference_place_no_tag_and_end_a_pass():
    path = line(0.0, np.nan, 0.01)
    assert place_tags(path, 100.0).sighted == {0: (0,), 2: (0,)}
    assert len(place_tags(line(np.nan), 1.0).places_m) == 0


@given(steps=st.lists(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), min_size=1, max_size=80))
def test_every_frame_is_near_a_tag_and_every_sighting_within_reach(steps):
    path = np.cumsum(np.array(steps), axis=0)
    tags = place_tags(path, 1.0)
    distances = np.linalg.norm(path[:, None] - tags.places_m[None], axis=2)
    assert (distances.min(axis=1) < 1.0).all()
    between = np.linalg.norm(tags.places_m[:, None] - tags.places_m[None], axis=2)
    assert (between[~np.eye(len(between), dtype=bool)] >= 1.0).all()
    for frame, numbers in tags.sighted.items():
        assert all(distances[frame, number] <= 0.15 for number in numbers)
    assert {number for numbers in tags.sighted.values() for number in numbers} == set(
        range(len(tags.places_m))
    )
