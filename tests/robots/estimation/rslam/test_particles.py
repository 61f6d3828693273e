"""Laws of resampling and of the ancestry of particles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.estimation.rslam.lineage import Lineage
from robots.estimation.rslam.particles import Particles
from robots.se2 import GaussianPose, Pose2


@given(st.integers(0, 2**32 - 1), st.integers(2, 60))
def test_each_particle_leaves_as_many_heirs_as_its_weight_says(seed, count):
    random = np.random.default_rng(seed)
    particles = Particles(Pose2(), count, (seed,))
    particles.move(GaussianPose(Pose2(1.0, 0.0, 0.0), np.eye(3) * 0.1))
    before = particles.poses.copy()
    particles.weigh(random.normal(size=count) * 3.0)
    share = particles.weights * count
    ancestors = particles.resample()
    heirs = np.bincount(ancestors, minlength=count)
    assert (np.abs(heirs - share) < 1.0 + 1e-9).all()
    assert (particles.poses == before[:, ancestors]).all()
    assert particles.effective == pytest.approx(count)
    alive = np.flatnonzero(heirs)
    assert (ancestors[alive] == alive).all()  # whoever lives stays in place


@given(st.integers(0, 2**32 - 1))
def test_a_particle_has_the_path_that_it_and_its_ancestors_drove(seed):
    random = np.random.default_rng(seed)
    count = 7
    lineage, paths = Lineage(Pose2(), count), [[(0.0, 0.0, 0.0)] for _ in range(count)]
    for _ in range(int(random.integers(0, 150))):
        if random.random() < 0.4:
            ancestors = np.sort(random.integers(0, count, count))
            lineage.resampled(ancestors)
            paths = [list(paths[k]) for k in ancestors]
        else:
            poses = random.uniform(-3.0, 3.0, (3, count))
            lineage.add(poses)
            for path, pose in zip(paths, poses.T, strict=True):
                path.append(tuple(pose))
    for k, path in enumerate(paths):
        found = [(pose.x, pose.y, pose.theta) for pose in lineage.path(k)]
        assert np.array(found) == pytest.approx(np.array(path), abs=1e-12)
    assert len(lineage) == len(paths[0])


def test_the_past_that_all_share_is_kept_once():
    lineage, random = Lineage(Pose2(), 100), np.random.default_rng(0)
    for _ in range(400):
        lineage.resampled(np.sort(random.integers(0, 100, 100)))
        lineage.add(np.zeros((3, 100)))
    kept = sum(len(poses) for poses, _ in lineage._layers)
    assert kept < 100 * 60


def test_the_belief_averages_headings_on_the_circle():
    particles = Particles(Pose2(0.0, 0.0, np.pi - 0.01), 4000, (1,))
    particles.move(GaussianPose(Pose2(), np.diag([0.01, 0.04, 0.01])))
    assert abs(particles.belief.mean.theta) > 3.0
    assert np.diag(particles.belief.covariance) == pytest.approx([0.01, 0.04, 0.01], rel=0.1)
