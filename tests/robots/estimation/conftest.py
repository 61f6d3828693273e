"""Rooms of straight walls with an exact laser: what a scan of them must be is known to the last digit."""

from collections.abc import Callable

import numpy as np
import pytest

from robots.se2 import Pose2
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
