"""Maps of other robots: frames found by common tags, nothing counted twice, bad ones told of and survived."""

from dataclasses import replace

import numpy as np
import pytest

from robots.config import AgentConfig, EkfConfig
from robots.estimation.ekf.filter import EkfFilter
from robots.se2 import GaussianPose, Pose2
from robots.tags.map_memory import TagBelief, WriterMap

WHITE = replace(AgentConfig(), ekf=EkfConfig(error_lasts_s=0.0))
ELSEWHERE = Pose2(7.0, -3.0, 2.0)  # where another robot's map begins


def _turned(belief, frame):
    x, y = frame.inverse().transform_point(belief.x_m, belief.y_m)
    c, s = np.cos(-frame.theta), np.sin(-frame.theta)
    turn = np.array([[c, -s], [s, c]])
    spread = (
        turn @ [[belief.variance_x, belief.covariance_xy], [belief.covariance_xy, belief.variance_y]] @ turn.T
    )
    return TagBelief(belief.tag_id, x, y, spread[0, 0], spread[0, 1], spread[1, 1])


def _left(writer, revision, tag_filter, frame=ELSEWHERE):
    return WriterMap(writer, revision, tuple(_turned(b, frame) for b in tag_filter.own_map()))


def _other(tag_walk, seed=50, **more):
    walk = tag_walk(seed, **more)
    return walk.run(EkfFilter("r2", WHITE, walk.start))


def _young(tag_walk, seed, steps=60):
    walk = tag_walk(seed, steps=steps)
    return walk, walk.run(EkfFilter("r1", WHITE, walk.start))


def _doubts(tag_filter, text):
    told = tag_filter.take_doubts()
    assert [d for d in told if text in d], told
    assert tag_filter.take_doubts() == ()


def test_a_map_places_tags_never_seen_and_makes_the_known_ones_surer(tag_walk):
    other = _other(tag_walk)
    walk, tag_filter = _young(tag_walk, 1)
    before, own = tag_filter.tags(), tag_filter.own_map()
    tag_filter.read_map(_left("r2", 1, other))
    after = tag_filter.tags()
    assert len(after) > len(before)
    assert all(after[t].variance_x <= before[t].variance_x + 1e-9 for t in before)
    off = [np.hypot(b.x_m - walk.tags[t][0], b.y_m - walk.tags[t][1]) for t, b in after.items()]
    assert np.mean(off) < 0.5
    assert tag_filter.own_map() == own
    assert tag_filter.take_doubts() == ()


def test_a_map_read_again_and_again_is_counted_once(tag_walk):
    other = _other(tag_walk)
    _, tag_filter = _young(tag_walk, 2)
    left = _left("r2", 1, other)
    tag_filter.read_map(left)
    once = tag_filter.tags()
    for revision in (1, 1, 0, 2, 3, 4):
        tag_filter._now_s += 10.0
        tag_filter.read_map(replace(left, revision=revision))
    for tag_id, belief in tag_filter.tags().items():
        assert belief.variance_x == pytest.approx(once[tag_id].variance_x, rel=1e-9)


def test_beliefs_stay_honest_however_often_maps_are_read(tag_walk):
    """NEES of the pose, and of all tags but for where the map lies, while two robots' maps keep coming."""
    pose_nees, tag_nees = [], []
    for seed in range(6):
        walk = tag_walk(seed, steps=120)
        tag_filter = EkfFilter("r1", WHITE, walk.start)
        others = []
        for k in (1, 2):
            theirs = tag_walk(100 * k + seed, steps=120)
            others.append((theirs, EkfFilter(f"o{k}", WHITE, theirs.start)))

        def on_step(k, others=others, tag_filter=tag_filter):
            for walk, other in others:
                walk.steps = 1
                walk.run(other)
                other._now_s = float(k)
                if k % 20 == 19:
                    tag_filter.read_map(_left(other_name(other), k, other))

        def other_name(other, others=others):
            return f"o{[o for _, o in others].index(other)}"

        walk.run(tag_filter, on_step=on_step)
        off = tag_filter.belief.mean.as_array() - walk.pose.as_array()
        off[2] = (off[2] + np.pi) % (2 * np.pi) - np.pi
        pose_nees.append(off @ np.linalg.solve(tag_filter.belief.covariance, off) / 3.0)
        for tag_id, b in tag_filter.tags().items():
            miss = np.array([b.x_m, b.y_m]) - walk.tags[tag_id]
            spread = [[b.variance_x, b.covariance_xy], [b.covariance_xy, b.variance_y]]
            tag_nees.append(miss @ np.linalg.solve(spread, miss) / 2.0)
    assert np.mean(pose_nees) < 1.6
    assert np.mean(tag_nees) < 1.5


def test_what_is_left_in_memories_never_holds_what_was_read(tag_walk):
    other = _other(tag_walk)
    walk, reader = _young(tag_walk, 3)
    walk_again, alone = _young(tag_walk, 3)
    reader.read_map(_left("r2", 1, other))
    for w, f in ((walk, reader), (walk_again, alone)):
        w.steps = 30
        w.run(f)
    assert reader.own_map() == alone.own_map()


def test_one_common_tag_is_not_enough_and_a_second_is(tag_walk):
    other = _other(tag_walk)
    walk = tag_walk(4, noise=0.0)
    tag_filter = EkfFilter("r1", WHITE, walk.start)
    ids = iter(list(walk.tags))
    sighting = next(s for t in ids if (s := walk.sighting(t, 0.0)) is not None)
    tag_filter.see(sighting)
    tag_filter.read_map(_left("r2", 1, other))
    assert set(tag_filter.tags()) == {sighting.tag_id}
    tag_filter.see(next(s for t in ids if (s := walk.sighting(t, 0.5)) is not None))
    for t in ids:
        if (s := walk.sighting(t, 1.0)) is not None:
            tag_filter.see(s)
    assert len(tag_filter.tags()) > 6
    assert tag_filter.take_doubts() == ()


def test_numbers_that_are_none_and_absurd_covariances_are_left_out(tag_walk):
    other = _other(tag_walk)
    _, tag_filter = _young(tag_walk, 5)
    good = _left("r2", 1, other)
    bad = (
        TagBelief("X1", float("nan"), 0.0, 1.0, 0.0, 1.0),
        TagBelief("X2", 0.0, 0.0, -1.0, 0.0, 1.0),
        TagBelief("X3", 0.0, 0.0, 1.0, 5.0, 1.0),
        TagBelief("X4", 0.0, 0.0, 1e12, 0.0, 1e12),
        TagBelief("X5", 0.0, 0.0, 1e-30, 0.0, 1e-30),
        TagBelief("X6", 1e30, 0.0, 1.0, 0.0, 1.0),
        TagBelief("X7", 1.0, 0.0, 1.0, 0.0, 1.0),
        TagBelief("X7", 2.0, 0.0, 1.0, 0.0, 1.0),
    )
    tag_filter.read_map(replace(good, beliefs=(*good.beliefs, *bad)))
    assert not {f"X{k}" for k in range(1, 8)} & set(tag_filter.tags())
    assert set(tag_filter.tags()) >= {b.tag_id for b in good.beliefs}
    _doubts(tag_filter, "impossible or repeated places for 8 tags")


def test_a_memory_of_another_mission_is_told_of_and_left_out(tag_walk):
    other = _other(tag_walk)
    _, tag_filter = _young(tag_walk, 6)
    before = tag_filter.tags()
    beliefs = list(_left("r9", 1, other).beliefs)
    shuffled = np.random.default_rng(1).permutation(len(beliefs))
    foreign = tuple(replace(beliefs[k], tag_id=b.tag_id) for k, b in zip(shuffled, beliefs, strict=True))
    tag_filter.read_map(WriterMap("r9", 1, foreign))
    assert tag_filter.tags() == before
    _doubts(tag_filter, "does not fit the tags here")


def test_a_tag_moved_since_it_was_mapped_is_left_out_of_the_map(tag_walk):
    other = _other(tag_walk)
    walk, tag_filter = _young(tag_walk, 7)
    moved = next(t for t in tag_filter.tags())
    left = _left("r2", 1, other)
    beliefs = tuple(replace(b, x_m=b.x_m + 5.0) if b.tag_id == moved else b for b in left.beliefs)
    tag_filter.read_map(replace(left, beliefs=beliefs))
    _doubts(tag_filter, f"Tag {moved} lies elsewhere")
    here = tag_filter.tags()[moved]
    assert np.hypot(here.x_m - walk.tags[moved][0], here.y_m - walk.tags[moved][1]) < 0.6


def test_a_tag_that_is_moved_is_learnt_anew(tag_walk):
    walk, tag_filter = _young(tag_walk, 8, steps=100)
    seen = [t for t in walk.tags if walk.sighting(t, 1e3) is not None]
    walk.tags[seen[0]] = [walk.pose.x + 2.0, walk.pose.y + 2.0]
    walk.steps = 40
    walk.run(tag_filter)
    _doubts(tag_filter, f"Tag {seen[0]} is not where it was")
    here = tag_filter.tags()[seen[0]]
    assert np.hypot(here.x_m - walk.tags[seen[0]][0], here.y_m - walk.tags[seen[0]][1]) < 1.0


def test_two_tags_of_one_id_are_told_of_and_not_used(tag_walk):
    walk, tag_filter = _young(tag_walk, 9)
    places = [[walk.pose.x + 2.0, walk.pose.y], [walk.pose.x, walk.pose.y + 3.0]]
    walk.reach_m, walk.steps = 1e3, 40
    for k in range(8):
        walk.tags["twice"] = places[k % 2]
        walk.run(tag_filter)
    told = " ".join(tag_filter.take_doubts())
    assert "Two tags seem to answer to the id twice" in told
    assert "twice" not in tag_filter.tags()
    off = tag_filter.belief.mean.distance(walk.pose)
    assert off < 0.5


def test_impossible_sightings_are_told_of_and_left_out(tag_walk):
    walk, tag_filter = _young(tag_walk, 10)
    sighting = next(s for t in walk.tags if (s := walk.sighting(t, 1e3)) is not None)
    before = tag_filter.belief
    for bad in (
        {"range_m": float("nan")},
        {"range_m": -1.0},
        {"range_sd_m": 0.0},
        {"bearing_rad": float("inf")},
    ):
        assert not tag_filter.see(replace(sighting, **bad))
    assert tag_filter.belief.mean == before.mean
    _doubts(tag_filter, "impossible range or bearing")
    tag_filter.predict(GaussianPose.exact(Pose2(0.1, 0.0, 0.0)))
    assert tag_filter.see(sighting)
