"""Rooms of straight walls with an exact laser, and random tag graphs whose truth is known."""

from collections.abc import Callable
from math import pi

import numpy as np
import pytest

from robots.estimation.graph.solve import GraphProblem
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import GaussianPose, Pose2, wrap, wrap_array
from robots.types import LaserScan

Scanner = Callable[..., LaserScan]


def swept(
    walls: np.ndarray,
    pose: Pose2,
    discs: np.ndarray | None = None,
    radius_m: float = 0.22,
    beams: int = 360,
    field_rad: float = 2.0 * np.pi,
    range_max_m: float = 30.0,
    sd_m: float = 0.0,
    rng: np.random.Generator | None = None,
) -> LaserScan:
    """A sweep of segments ``walls``, (n, 4) as x0 y0 x1 y1, and of round things, (k, 2), from a pose."""
    angles = -field_rad / 2.0 + np.arange(beams) * field_rad / beams
    direction = np.column_stack([np.cos(angles + pose.theta), np.sin(angles + pose.theta)])
    start, along = walls[:, :2] - (pose.x, pose.y), walls[:, 2:] - walls[:, :2]
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = direction[:, :1] * along[:, 1] - direction[:, 1:] * along[:, 0]
        reach = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
        share = (start[:, 0] * direction[:, 1:] - start[:, 1] * direction[:, :1]) / cross
    hit = (reach > 0.0) & (share >= 0.0) & (share <= 1.0)
    ranges = np.where(hit, reach, np.inf).min(axis=1, initial=np.inf)
    for x, y in np.zeros((0, 2)) if discs is None else discs:
        to = np.array([x - pose.x, y - pose.y])
        ahead = direction @ to
        inside = radius_m**2 - (to @ to - ahead**2)
        near = ahead - np.sqrt(np.maximum(inside, 0.0))
        ranges = np.minimum(ranges, np.where((inside > 0.0) & (near > 0.0), near, np.inf))
    if sd_m > 0.0:
        assert rng is not None
        ranges = ranges + sd_m * rng.standard_normal(beams)
    ranges = np.where(ranges < range_max_m, ranges, range_max_m)
    return LaserScan(ranges.astype(np.float32), float(angles[0]), field_rad / beams, range_max_m)


def polygon(*corners: tuple[float, float]) -> np.ndarray:
    points = np.array(corners)
    return np.hstack([points, np.roll(points, -1, axis=0)])


@pytest.fixture
def sweep() -> Scanner:
    return swept


@pytest.fixture
def outline() -> Callable[..., np.ndarray]:
    """Walls, (n, 4), round a polygon of corners."""
    return polygon


@pytest.fixture
def room() -> np.ndarray:
    """An L-shaped room with a slanted wall: every direction is seen, no two places look alike."""
    return polygon((-3.0, -2.0), (4.0, -2.0), (4.0, 1.0), (1.5, 1.0), (1.5, 3.5), (-2.0, 3.5), (-3.0, 1.5))


@pytest.fixture
def corridor() -> np.ndarray:
    """Two bare walls, 2 m apart, whose ends are out of sight."""
    return np.array([[-60.0, -1.0, 60.0, -1.0], [-60.0, 1.0, 60.0, 1.0]])


def spread(rng: np.random.Generator, count: int, size: int, sd: float) -> np.ndarray:
    """Random covariances, (count, size, size), with correlations."""
    roots = sd * (np.eye(size) + 0.3 * rng.standard_normal((count, size, size)))
    return roots @ roots.transpose(0, 2, 1) + 1e-6 * np.eye(size)


class Graphs:
    """Random graphs and their truth."""

    @staticmethod
    def truth_of(rng: np.random.Generator, poses: int, tags: int) -> tuple[np.ndarray, np.ndarray]:
        true_poses = np.column_stack([rng.uniform(-5, 5, (poses, 2)), rng.uniform(-pi, pi, poses)])
        return true_poses, rng.uniform(-5, 5, (tags, 2))

    @staticmethod
    def measured(
        rng: np.random.Generator,
        true_poses: np.ndarray,
        true_tags: np.ndarray,
        noise: float = 1.0,
        moved: float = 0.3,
        headings: bool = True,
    ) -> GraphProblem:
        """A chain with a few loop closures, every tag seen twice.

        ``noise`` scales what the measurements err, ``moved`` how far the initial values lie from the truth.
        """
        n, m = len(true_poses), len(true_tags)
        loops = [(int(i), int(j)) for i, j in rng.integers(0, n, (3, 2)) if i != j]
        pairs = np.array([(k, k + 1) for k in range(n - 1)] + loops, np.int64)
        covariances = spread(rng, len(pairs), 3, 0.05)
        true = [Pose2.from_array(pose) for pose in true_poses]
        between = np.array([true[i].between(true[j]).as_array() for i, j in pairs])
        errors = np.array([rng.multivariate_normal(np.zeros(3), c) for c in covariances])
        seen = np.array([(int(rng.integers(n)), k) for k in range(m) for _ in range(2)], np.int64)
        offsets = np.array([
            Pose2.from_array(true_poses[i]).inverse().transform(true_tags[k][None])[0] for i, k in seen
        ])  # fmt: skip
        seen_covariances = spread(rng, len(seen), 2, 0.06)
        blur = np.array([rng.multivariate_normal(np.zeros(2), c) for c in seen_covariances])
        known = np.arange(0, n, 2) if headings else np.zeros(0, np.int64)
        start = moved * rng.standard_normal((n, 3)) * (1.0, 1.0, 0.3)
        start[0] = 0.0
        return GraphProblem(
            poses=np.column_stack([(true_poses + start)[:, :2], wrap_array((true_poses + start)[:, 2])]),
            tags=true_tags + moved * rng.standard_normal((m, 2)),
            edge_pairs=pairs,
            edge_poses=between + noise * errors,
            edge_covariances=covariances,
            sighting_pairs=seen,
            sighting_offsets=offsets + noise * blur,
            sighting_covariances=seen_covariances,
            prior_index=np.zeros(1, np.int64),
            prior_poses=true_poses[:1],
            prior_sds=np.full((1, 3), 0.02),
            heading_index=known,
            heading_rad=true_poses[known, 2] + noise * 0.03 * rng.standard_normal(len(known)),
            heading_sd_rad=np.full(len(known), 0.03),
        )

    @staticmethod
    def city(rng: np.random.Generator, count: int, turn_sd: float = 0.03) -> tuple[GraphProblem, np.ndarray]:
        """A walk along the streets of a grid that closes a loop wherever it comes by again, and its truth."""
        here, walk = Pose2(), [Pose2()]
        for _ in range(count - 1):
            turn = float(rng.choice([0.0, 0.0, pi / 2, -pi / 2]))
            ahead = here @ Pose2(1.0, 0.0, turn)
            if max(abs(ahead.x), abs(ahead.y)) > 6.0:  # the edge of town
                ahead = here @ Pose2(0.0, 0.0, pi / 2)
            here = ahead
            walk.append(here)
        truth = np.array([pose.as_array() for pose in walk])
        pairs = [(k, k + 1) for k in range(count - 1)]
        at: dict[tuple[int, int], int] = {}
        for k, (x, y, _) in enumerate(truth):
            place = (round(x), round(y))
            if place in at and k - at[place] > 4:
                pairs.append((at[place], k))
            at[place] = k
        sd = np.array([0.05, 0.05, turn_sd])
        measured = np.array([walk[i].between(walk[j]).as_array() for i, j in pairs])
        measured += sd * rng.standard_normal(measured.shape)
        none = np.zeros(0)
        return GraphProblem(
            poses=truth,
            tags=none,
            edge_pairs=np.array(pairs),
            edge_poses=measured,
            edge_covariances=np.tile(np.diag(sd**2), (len(pairs), 1, 1)),
            sighting_pairs=none,
            sighting_offsets=none,
            sighting_covariances=none,
            prior_index=np.zeros(1, np.int64),
            prior_poses=truth[:1],
            prior_sds=np.full((1, 3), 0.01),
        ), truth


@pytest.fixture
def graphs() -> type[Graphs]:
    return Graphs


class TagWalk:
    """A robot on a wavy circle among tags; what it measures is drawn from the noise it states."""

    step_sd = np.array([0.02, 0.01, 0.01])

    def __init__(
        self,
        seed: int,
        steps: int = 300,
        range_sd_m: float = 0.1,
        bearing_sd_rad: float = 0.03,
        reach_m: float = 6.0,
        lasting_s: float = 0.0,
        start: Pose2 | None = None,
        side_m: float = 16.0,
        noise: float = 1.0,
    ) -> None:
        self.rng = np.random.default_rng(seed)
        x = np.arange(-side_m / 2, side_m / 2 + 0.1, 4.0)
        self.tags = {f"T{k}": p for k, p in enumerate(np.array(np.meshgrid(x, x)).reshape(2, -1).T.tolist())}
        self.start = start or Pose2(0.0, -5.0, 0.0)
        self.steps, self.reach_m, self.noise = steps, reach_m, noise
        self.range_sd_m, self.bearing_sd_rad, self.lasting_s = range_sd_m, bearing_sd_rad, lasting_s
        self.pose = self.start
        self._errors: dict[str, tuple[int, np.ndarray]] = {}

    def run(self, tag_filter, step_s: float = 0.5, on_step=lambda k: None, bearing: bool = True):
        """Feed a filter whose map frame is the world's."""
        for k in range(self.steps):
            motion = Pose2(0.25, 0.0, 0.05 + 0.04 * np.sin(k / 9.0))
            self.pose = self.pose @ motion
            seen_sd = self.step_sd * self.noise * self.rng.standard_normal(3)
            told = Pose2.from_array(motion.as_array() + seen_sd)
            tag_filter.predict(GaussianPose(told, np.diag(self.step_sd**2)))
            for tag_id in self.tags:
                sighting = self.sighting(tag_id, k * step_s, bearing)
                if sighting is not None:
                    tag_filter.see(sighting)
            on_step(k)
        return tag_filter

    def sighting(self, tag_id: str, stamp_s: float, bearing: bool = True) -> RangeSighting | None:
        """What the robot measures of a tag from where it is."""
        x, y = self.pose.inverse().transform_point(*self.tags[tag_id])
        if np.hypot(x, y) > self.reach_m:
            return None
        off = self._error(tag_id, stamp_s) * (self.range_sd_m, self.bearing_sd_rad) * self.noise
        measured = max(float(np.hypot(x, y) + off[0]), 0.0)
        if not bearing:
            return RangeSighting(tag_id, stamp_s, measured, self.range_sd_m)
        direction = wrap(float(np.arctan2(y, x) + off[1]))
        return RangeSighting(tag_id, stamp_s, measured, self.range_sd_m, direction, self.bearing_sd_rad)

    def _error(self, tag_id: str, stamp_s: float) -> np.ndarray:
        fresh = self.rng.standard_normal(2)
        if self.lasting_s and tag_id in self._errors:
            last_s, last = self._errors[tag_id]
            rho = np.exp(-(stamp_s - last_s) / self.lasting_s)
            fresh = rho * last + np.sqrt(1.0 - rho * rho) * fresh
        self._errors[tag_id] = (stamp_s, fresh)
        return fresh


@pytest.fixture
def tag_walk() -> type[TagWalk]:
    return TagWalk
