"""The nodes that particles know: ranges until the place shows, then filters of one place or of two."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robots.config import RangeSlamConfig
from robots.estimation.rslam.particles import copy_columns
from robots.estimation.rslam.places import vote
from robots.estimation.rslam.range_kernels import ROWS, WORK_ROWS, age_offset, correct, innovations, settle
from robots.graph_report import IntArray
from robots.se2 import Array

Noise = tuple[float, float]  # deviation in metres, or of the logarithm; the other is 0

_GATHERED = 32  # ranges kept of a node without a place
_FEWEST = 4  # that make a place
_LONGER = 1.3  # than the way between them: by so much two ranges may differ
_STRAIGHT = 0.35  # of the distance: a place known so well is one for a Kalman filter
_MOST = 0.9  # of the particles
_GONE = 1e-3  # a place with a smaller share is given up


@dataclass(slots=True)
class Gathered:
    """Ranges of a node without a place: from where each particle, and their mean, measured them."""

    ranges_m: list[float] = field(default_factory=list)
    noises: list[Noise] = field(default_factory=list)
    mean_antennas: list[Array] = field(default_factory=list)  # each (2,)
    antennas: list[Array] = field(default_factory=list)  # each (2, M)
    spacing_m: float = 0.0
    added: int = 0
    due: int = 4  # so many ranges have to have been added before the place is looked for

    def add(self, range_m: float, noise: Noise, antennas: Array, weights: Array) -> bool:
        """Keep a range that was measured away from the one before; say whether it was."""
        sd_m = noise[0]  # what shadows a signal belongs to the place: each counts
        here = antennas @ weights
        if self.mean_antennas and np.hypot(*(here - self.mean_antennas[-1])) < max(self.spacing_m, sd_m):
            return False
        self.added += 1
        self.ranges_m.append(range_m)
        self.noises.append(noise)
        self.mean_antennas.append(here)
        self.antennas.append(antennas.copy())
        if len(self.ranges_m) > _GATHERED:
            if noise[1] > 0.0:
                self._merge()
            else:  # every other one, from now on twice as far apart
                self.spacing_m = 2.0 * max(self.spacing_m, sd_m)
                for kept in (self.ranges_m, self.noises, self.mean_antennas, self.antennas):
                    del kept[1::2]
        return True

    def _merge(self) -> None:
        """Let neighbours become one: signals of different places err independently, their mean by less."""
        for k in range(len(self.ranges_m) // 2):
            self.ranges_m[k : k + 2] = [float(np.sqrt(self.ranges_m[k] * self.ranges_m[k + 1]))]
            self.noises[k : k + 2] = [(0.0, float(np.hypot(self.noises[k][1], self.noises[k + 1][1])) / 2.0)]
            for kept in (self.mean_antennas, self.antennas):
                kept[k : k + 2] = [(kept[k] + kept[k + 1]) / 2.0]

    def believed(self) -> NDArray[np.bool_]:
        """Tell which ranges, (k,), are in keeping with at least half of the others.

        Two ranges of one node differ by no more than the way between where they were measured.
        """
        places, ranges, noises = np.array(self.mean_antennas), np.array(self.ranges_m), np.array(self.noises)
        sds = noises[:, 0] + noises[:, 1] * ranges
        way = np.hypot(*(places[:, None] - places[None]).T)
        slack = 3.0 * np.hypot(sds[:, None], sds[None])
        agree = np.abs(ranges[:, None] - ranges[None]) <= _LONGER * way + slack
        kept: NDArray[np.bool_] = agree.sum(axis=1) > len(ranges) / 2
        return kept


class Node:
    """One node: its ranges while it has no place, then a block of filters for each place it may have."""

    def __init__(self) -> None:
        self.gathered = Gathered()
        self.blocks: list[Array] = []  # each (12, M)
        self.log_shares = np.zeros((0, 0))  # (blocks, M)
        self.seen_s = 0.0
        self.fits = True  # its latest range did
        self.misfits = 0  # ranges in a row that did not
        self.astray = Gathered()  # those ranges
        self.moves = 0  # how often it turned up at another place
        self.ignored = False

    @property
    def is_placed(self) -> bool:
        """Whether its place is known but for a mirror image."""
        return bool(self.blocks)

    def resampled(self, ancestors: IntArray) -> None:
        """Follow the particles."""
        for block in self.blocks:
            copy_columns(block, ancestors)
        if len(self.blocks) > 1:
            copy_columns(self.log_shares, ancestors)
        for antennas in (*self.gathered.antennas, *self.astray.antennas):
            copy_columns(antennas, ancestors)

    def place(self, scales: Array, weights: Array, config: RangeSlamConfig) -> Array | None:
        """Begin filters where the ranges agree on one or two places.

        Returns:
            log-likelihoods (M,) of the ranges; None while the place is open.
        """
        gathered = self.gathered
        if gathered.added < gathered.due:
            return None
        gathered.due = gathered.added + 1 + gathered.added // 4
        believed = gathered.believed()
        if believed.sum() < _FEWEST:
            return None
        ranges, noises = np.array(gathered.ranges_m)[believed], np.array(gathered.noises)[believed]
        mean_antennas = np.array(gathered.mean_antennas)[believed]
        mean = float(scales[0] @ weights)
        spread = float(np.sqrt(weights @ ((scales[0] - mean) ** 2 + scales[1])))
        found = vote(mean_antennas, ranges, noises, (mean, spread), config.offset_sd_m)
        if not found:
            return None
        antennas = np.array(gathered.antennas)[believed]
        offset_variance = config.offset_sd_m**2
        starts = [(each.x_m, each.y_m) for each in found]
        while True:
            evidence = np.empty((len(starts), scales.shape[1]))
            self.blocks = [np.empty((ROWS, scales.shape[1])) for _ in starts]
            for start, block, fits in zip(starts, self.blocks, evidence, strict=True):
                settle(
                    block, scales, antennas, ranges, noises, start, offset_variance, fits, len(starts) == 1
                )
            if len(starts) == 1 or not _are_one(self.blocks[0], self.blocks[1], scales, weights):
                break
            del starts[1]
        by_signal = bool((noises[:, 1] > 0.0).any())  # from metres, the votes are sharp enough
        if by_signal and not all(_is_sure(block, scales, mean_antennas, weights) for block in self.blocks):
            self.blocks = []
            return None
        self.gathered = Gathered()
        total: Array = np.logaddexp.reduce(evidence, axis=0)
        self.log_shares = evidence - total
        return total

    def see(
        self, scales: Array, antennas: Array, range_m: float, noise: Noise, outliers: tuple[float, float]
    ) -> tuple[list[Array], Array]:
        """Return the innovations of each place, (9, M), and the log-likelihoods (M,) over all places."""
        works = []
        for block in self.blocks:
            work = np.empty((WORK_ROWS, antennas.shape[1]))
            innovations(block, scales, antennas, range_m, noise, outliers, work)
            works.append(work)
        if len(works) == 1:
            return works, works[0][2]
        joint = self.log_shares + np.array([work[2] for work in works])
        return works, np.logaddexp.reduce(joint, axis=0)

    def correct(self, scales: Array, works: list[Array], total: Array) -> None:
        """Correct each place by its innovations, and their shares; of two places none teaches the scale."""
        alone = len(self.blocks) == 1
        for block, work in zip(self.blocks, works, strict=True):
            correct(block, scales, work, alone)
        if not alone:
            self.log_shares += np.array([work[2] for work in works]) - total

    def fit(self, works: list[Array], weights: Array) -> float:
        """Return how probable it is that a range with these innovations is no outlier."""
        if len(works) == 1:
            return float(works[0][3] @ weights)
        shares = np.exp(self.log_shares)
        return float(sum((share * work[3]) @ weights for share, work in zip(shares, works, strict=True)))

    def settle_mirror(self, weights: Array) -> None:
        """Give up a place that hardly any particle believes in."""
        if len(self.blocks) > 1:
            shares = np.exp(self.log_shares) @ weights
            keep = [k for k, share in enumerate(shares) if share > _GONE]
            if len(keep) < len(self.blocks):
                self.blocks = [self.blocks[k] for k in keep]
                self.log_shares = self.log_shares[keep]
                self.log_shares -= np.logaddexp.reduce(self.log_shares, axis=0)

    def age(self, kept: float, gained: float) -> None:
        """Let the offset change."""
        for block in self.blocks:
            age_offset(block, kept, gained)


def _is_sure(block: Array, scales: Array, mean_antennas: Array, weights: Array) -> bool:
    """Tell whether a place is known so well that ranges are straight over it, in most particles."""
    places = block[:2] + block[3:5] * scales[0]
    away = np.hypot(*(places - mean_antennas.mean(axis=0)[:, None]))
    mean, half = (block[6] + block[8]) / 2.0, (block[6] - block[8]) / 2.0
    longest = np.sqrt(mean + np.hypot(half, block[7]))  # of the ellipse
    return bool((longest <= _STRAIGHT * away) @ weights > _MOST)


def _are_one(first: Array, second: Array, scales: Array, weights: Array) -> bool:
    """Tell whether two places came out as the same one."""
    one, other = (block[:2] + block[3:5] * scales[0] for block in (first, second))
    apart = ((one - other) ** 2).sum(axis=0) @ weights
    return bool(apart < (first[6] + first[8]) @ weights)
