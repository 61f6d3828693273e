"""RSLAM (Sun 2009): a particle filter over the path; each particle has Kalman filters of the nodes."""

from __future__ import annotations

from copy import deepcopy
from math import exp, isfinite
from zlib import crc32

import numpy as np

from robots.config import AgentConfig
from robots.estimation.rslam.lineage import Lineage
from robots.estimation.rslam.nodes import Gathered, Node, Noise
from robots.estimation.rslam.particles import Particles, copy_columns
from robots.estimation.rslam.range_kernels import spread_of
from robots.estimation.rslam.shared_maps import SharedMaps
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2, wrap_array
from robots.tags.map_memory import TagBelief, WriterMap

_RESOLVED = 0.95  # a node with two possible places is known once one has this share

_FITS = 0.1  # a range that is so probably no outlier counts as one that fits
_PATIENCE = 10  # ranges in a row that do not fit before the node's place is doubted
_STUBBORN = 60  # and after so many without a place they agree on, they are used as they are
_MOST_MOVES = 4
_RECENT_S = 60.0
_MOST_NODES = 1000


class RangeSlam:
    """A TagFilter over ranges alone; bearings are not looked at.

    ``leaves_map``: what it has by itself is kept apart from what others told, to be left in memories.
    """

    def __init__(self, robot_id: str, config: AgentConfig, start: Pose2, leaves_map: bool = True) -> None:
        own = config.rslam
        self._config = own
        self._particles = Particles(start, own.particles, (config.seed, crc32(robot_id.encode()), 3))
        self._scales = np.empty((2, own.particles))  # mean and variance in each particle
        self._scales[0], self._scales[1] = 1.0, own.scale_sd**2
        self._lineage = Lineage(start, own.particles)
        self._nodes: dict[str, Node] = {}
        self._doubts: list[str] = []
        self._told: dict[str, None] = {}
        self._has_compass = False
        self._shared = SharedMaps(own)
        self._leaves_map = leaves_map
        self._alone: RangeSlam | None = None  # the same without what others told, once somebody has

    @property
    def belief(self) -> GaussianPose:
        """Weighted mean and covariance of the particles."""
        return self._particles.belief

    @property
    def range_scale(self) -> float:
        """The scale of ranges, as all particles together have it."""
        return float(self._scales[0] @ self._particles.weights)

    def predict(self, moved: GaussianPose) -> None:
        """Move each particle by a displacement drawn about ``moved``."""
        if self._alone is not None:
            self._alone.predict(moved)
        self._particles.move(moved)

    def see_heading(self, heading_rad: float, sd_rad: float) -> None:
        """Weigh the particles by a compass."""
        if self._alone is not None:
            self._alone.see_heading(heading_rad, sd_rad)
        self._has_compass = True
        off = wrap_array(self._particles.poses[2] - heading_rad) / sd_rad
        self._particles.weigh(-0.5 * off * off)
        self._resample_if_due()

    def see(self, sighting: RangeSighting) -> bool:
        """Take in a range; say whether it fits what is known."""
        if self._alone is not None:
            self._alone.see(sighting)
        fitted = self._see(sighting)
        if self._shared.waiting:
            self._take_maps()
        return fitted

    def _see(self, sighting: RangeSighting) -> bool:
        node = self._node(sighting)
        if node is None:
            return False
        particles = self._particles
        antennas = _antennas(particles.poses, sighting.base_from_antenna)
        if not node.is_placed:
            return self._gather(node, sighting, antennas)
        self._age(node, sighting.stamp_s)
        outliers = (self._config.outlier_share, self._config.outlier_reach_m)
        range_m, noise = _measured(sighting)
        works, total = node.see(self._scales, antennas, range_m, noise, outliers)
        node.fits = node.fit(works, particles.weights) > _FITS
        if node.fits:
            node.misfits = 0
        elif self._is_astray(node, sighting, antennas):
            return False
        node.correct(self._scales, works, total)
        particles.weigh(total)
        node.settle_mirror(particles.weights)
        self._resample_if_due()
        return node.fits

    def anchor(self) -> None:
        """Remember the pose here as a vertex of the graph."""
        self._lineage.add(self._particles.poses)

    def anchors(self) -> list[Pose2]:
        """Return the poses remembered by the best particle."""
        return self._lineage.path(self._particles.best)

    def tags(self) -> dict[str, TagBelief]:
        """Return the nodes whose place is known, without those that may still lie at either of two."""
        found = {}
        for tag_id, node in self._nodes.items():
            spread = self._spread(node)
            if spread is not None:
                x, y, _ = spread[0]
                found[tag_id] = TagBelief(
                    tag_id, float(x), float(y), float(spread[1, 0]), float(spread[1, 1]), float(spread[2, 1])
                )
        return found

    def range_offset(self, tag_id: str) -> float:
        """Return by how much ranges of a node are too long, in metres; 0 where nothing was learnt."""
        node = self._nodes.get(tag_id)
        spread = None if node is None else self._spread(node)
        return 0.0 if spread is None else float(spread[0, 2])

    def own_map(self) -> tuple[TagBelief, ...]:
        """Return the nodes as this robot's own measurements alone have them."""
        return tuple((self._alone or self).tags().values())

    def read_map(self, other: WriterMap) -> None:
        """Take in a map that another robot left, now or once enough of its nodes are known here."""
        if self._shared.put(other):
            self._take_maps()

    def take_doubts(self) -> tuple[str, ...]:
        """Return, once, what is wrong with nodes, ranges and maps."""
        for doubt in self._shared.take_doubts():
            self._doubt(doubt)
        doubts, self._doubts = tuple(self._doubts), []
        return doubts

    def _node(self, sighting: RangeSighting) -> Node | None:
        """Return the node of a sighting, None where it cannot be used."""
        if not (isfinite(sighting.range_m) and sighting.range_m >= 0.0 and sighting.range_sd_m > 0.0):
            return None
        node = self._nodes.get(sighting.tag_id)
        if node is None:
            if len(self._nodes) >= _MOST_NODES:
                self._doubt(f"more than {_MOST_NODES} nodes were heard; the others are left out")
                return None
            node = self._nodes[sighting.tag_id] = Node()
        return None if node.ignored else node

    def _is_astray(self, node: Node, sighting: RangeSighting, antennas: Array) -> bool:
        """Tell whether a range that does not fit is better left out: a lone one, or the node has been moved.

        Ranges that keep contradicting a node while other nodes fit are gathered; once they agree on a place,
        the node is taken to be there. Where no other node fits, it is the robot that is elsewhere.
        """
        particles = self._particles
        node.misfits += 1
        if node.misfits == 1:
            node.astray = Gathered()
        node.astray.add(*_measured(sighting), antennas, particles.weights)
        if node.misfits < _PATIENCE:
            return True
        if not self._others_fit(node, sighting.stamp_s) or node.misfits > _STUBBORN:
            return False
        before, node.gathered = node.gathered, node.astray
        blocks, node.blocks = node.blocks, []
        fits = node.place(self._scales, particles.weights, self._config)
        if fits is None:
            node.gathered, node.blocks = before, blocks
            return True
        node.misfits, node.moves = 0, node.moves + 1
        node.ignored = node.moves >= _MOST_MOVES
        if node.ignored:
            self._doubt(
                f"node {sighting.tag_id} keeps turning up at different places, as if two had the same id;"
                " its ranges are left out"
            )
        else:
            self._doubt(f"node {sighting.tag_id} is no longer where it was; it gets a new place")
        return True

    def _others_fit(self, node: Node, stamp_s: float) -> bool:
        others = [
            each.fits
            for each in self._nodes.values()
            if each is not node and each.is_placed and stamp_s - each.seen_s < _RECENT_S
        ]
        return bool(others) and sum(others) > len(others) / 2

    def _doubt(self, text: str) -> None:
        if text not in self._told:
            self._told[text] = None
            self._doubts.append(text)

    def _take_maps(self) -> None:
        """Take in maps that wait; from then on what this robot has by itself is kept apart.

        What it has by itself is what it leaves in memories: what others told would come back as news.
        """
        weights = self._particles.weights
        if not self._shared.fits_any(self.tags, self._nodes, self._scales, weights, self._has_compass):
            return
        if self._alone is None and self._leaves_map:
            self._alone = deepcopy(self)
            self._alone._shared = SharedMaps(self._config)
        self._shared.take(self._nodes, self._particles, self._scales)
        for node in self._nodes.values():
            node.settle_mirror(self._particles.weights)
        self._resample_if_due()

    def _gather(self, node: Node, sighting: RangeSighting, antennas: Array) -> bool:
        particles = self._particles
        node.seen_s = sighting.stamp_s
        if node.gathered.add(*_measured(sighting), antennas, particles.weights):
            fits = node.place(self._scales, particles.weights, self._config)
            if fits is not None:
                particles.weigh(fits)
                self._resample_if_due()
        return True

    def _age(self, node: Node, stamp_s: float) -> None:
        lasting, sd = self._config.offset_lasts_s, self._config.offset_sd_m
        if lasting > 0.0 and stamp_s > node.seen_s:
            kept = exp(-(stamp_s - node.seen_s) / lasting)
            node.age(kept, sd * sd * (1.0 - kept * kept))
        node.seen_s = max(node.seen_s, stamp_s)

    def _resample_if_due(self) -> None:
        if self._particles.effective < self._config.resample_below * self._particles.count:
            ancestors = self._particles.resample()
            copy_columns(self._scales, ancestors)
            self._lineage.resampled(ancestors)
            for node in self._nodes.values():
                node.resampled(ancestors)

    def _spread(self, node: Node) -> Array | None:
        """Return mean (x, y, offset) and covariance of a node, (4, 3); None while its place is open."""
        if not node.is_placed:
            return None
        weights, best = self._particles.weights, 0
        if len(node.blocks) > 1:
            shares = np.exp(node.log_shares) @ weights
            best = int(np.argmax(shares))
            if shares[best] < _RESOLVED:
                return None
            weights = weights * np.exp(node.log_shares[best])
            weights = weights / weights.sum()
        return np.asarray(spread_of(node.blocks[best], self._scales, weights))


def _measured(sighting: RangeSighting) -> tuple[float, Noise]:
    """Return the range and its noise: in metres, or, for a signal's, of its logarithm."""
    if sighting.log_sd is None or sighting.median_m is None or sighting.median_m <= 0.0:
        return sighting.range_m, (sighting.range_sd_m, 0.0)
    return sighting.median_m, (0.0, max(sighting.log_sd, 1e-3))


def _antennas(poses: Array, base_from_antenna: Pose2) -> Array:
    x, y = base_from_antenna.x, base_from_antenna.y
    if x == 0.0 and y == 0.0:
        return poses[:2]
    c, s = np.cos(poses[2]), np.sin(poses[2])
    return np.array([poses[0] + c * x - s * y, poses[1] + s * x + c * y])
