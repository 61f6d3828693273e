"""Maps that other robots left in nodes' memories (Sun 2009 section 5.2), taken in by every particle.

A map holds its writer's own measurements alone and a newer one stands for the older ones, so nothing is
counted twice as long as each is taken for what it adds to the one before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robots.config import RangeSlamConfig
from robots.estimation.rslam.map_fit import MapFit, MapPlaces, fit, sane, to_places
from robots.estimation.rslam.map_kernels import align, align_by_ranges, begin, told
from robots.estimation.rslam.map_ranges import Heard, heard_of, locate
from robots.estimation.rslam.nodes import Gathered, Node
from robots.estimation.rslam.particles import Particles
from robots.estimation.rslam.range_kernels import ROWS
from robots.se2 import Array
from robots.tags.map_memory import TagBelief, WriterMap

_COMPASS_SD_RAD = 0.05  # between the norths of two robots
_ANY_TURN = 1e6  # variance
_MOST_NATS = 10.0  # by which one map may tell particles apart
_LEAST_FRAME = 1e-6  # m2 and rad2
_TWICE = 0.5  # a place is taken again once its variance is so much less than it was


@dataclass(slots=True)
class _Writer:
    newest: WriterMap
    places: MapPlaces
    tried_with: tuple[str, ...] = ()  # nodes that had a place at the last attempt
    fit: MapFit | None = None
    located: tuple[Array, Heard] | None = None  # how it lies by ranges alone
    due: int = 0  # so many ranges have to be gathered before that is tried again
    done: bool = False
    prior: Array | None = None  # information (3, 3) on how it lies, where all starts are known in one frame


class SharedMaps:
    """What others left: maps that wait until enough nodes are common, and what was taken of each."""

    def __init__(self, config: RangeSlamConfig) -> None:
        self._config = config
        self._writers: dict[str, _Writer] = {}
        self._taken: dict[tuple[str, str], Array] = {}  # covariance with which a writer's node was taken last
        self._turn_sd_rad: float | None = None
        self._doubts: list[str] = []

    def put(self, other: WriterMap) -> bool:
        """Keep a map to be taken in; say whether it is news."""
        known = self._writers.get(other.writer)
        if known is not None and other.revision <= known.newest.revision:
            return False
        places = sane(other)
        if len(places.ids) < len(other.beliefs):
            self._doubts.append(
                f"the map that {other.writer} left has places that cannot be true; they are left out"
            )
        prior = self._prior(other) if known is None else None  # later maps say the same once more
        self._writers[other.writer] = _Writer(other, places, prior=prior)
        return True

    def _prior(self, other: WriterMap) -> Array | None:
        """Return the information on how a map lies, (3, 3); None where nothing is known of that."""
        if not (self._config.starts_known and len(other.frame) == 6):
            return None
        spread = np.zeros((3, 3))
        spread[np.triu_indices(3)] = other.frame
        spread = spread + np.triu(spread, 1).T + np.eye(3) * _LEAST_FRAME
        if not (np.isfinite(spread).all() and np.linalg.eigvalsh(spread)[0] > 0.0):
            return None
        return np.asarray(np.linalg.inv(spread), np.float64)

    @property
    def waiting(self) -> bool:
        """Whether a map waits for more nodes in common."""
        return any(not each.done for each in self._writers.values())

    def take_doubts(self) -> list[str]:
        """Return, once, what is wrong with maps."""
        doubts, self._doubts = self._doubts, []
        return doubts

    def fits_any(
        self,
        tags: Callable[[], dict[str, TagBelief]],
        nodes: dict[str, Node],
        scales: Array,
        weights: Array,
        with_compass: bool,
    ) -> bool:
        """Find out how the maps that wait lie among the nodes with a place, ``tags``, or by ranges to others.

        Say whether one can be taken in.
        """
        known = frozenset(tag_id for tag_id, node in nodes.items() if len(node.blocks) == 1)
        self._turn_sd_rad = _COMPASS_SD_RAD if with_compass else None
        scale = float(scales[0] @ weights), float(np.sqrt(scales[1] @ weights))
        for name, writer in self._writers.items():
            common = known & frozenset(writer.places.ids)
            if writer.prior is not None and not writer.done:
                ids = tuple(tag_id for tag_id in writer.places.ids if tag_id in common)
                writer.fit = MapFit(np.zeros(3), writer.places, ids)
                continue
            if not writer.done:
                self._locate(writer, nodes, scale)
            tried_with = tuple(sorted(common))
            if writer.done or writer.located is not None or tried_with == writer.tried_with:
                continue
            writer.tried_with = tried_with
            try:
                writer.fit = fit(to_places(tags()), writer.places, self._turn_sd_rad)
            except ValueError:
                self._doubts.append(
                    f"the map that {name} left does not fit the nodes as they lie here, as if it were of"
                    " another mission; it is left out"
                )
        return any(each.fit is not None or each.located is not None for each in self._writers.values())

    def _locate(self, writer: _Writer, nodes: dict[str, Node], scale: tuple[float, float]) -> None:
        gathered = sum(nodes[tag_id].gathered.added for tag_id in writer.places.ids if tag_id in nodes)
        if gathered < writer.due:
            return
        writer.due = gathered + 3 + gathered // 4
        heard = heard_of(nodes, writer.places)
        frame = None if heard is None else locate(heard, scale, self._turn_sd_rad)
        if frame is not None and heard is not None:
            writer.located = frame, heard

    def take(self, nodes: dict[str, Node], particles: Particles, scales: Array) -> None:
        """Take in what fits."""
        for name, writer in self._writers.items():
            if writer.located is not None:
                self._take_located(name, writer.places, *writer.located, nodes, particles, scales)
                writer.located, writer.done = None, True
            elif writer.fit is not None:
                self._take(name, writer.fit, writer.prior, nodes, particles, scales)
                writer.fit, writer.done = None, True

    def _take_located(
        self,
        writer: str,
        other: MapPlaces,
        frame: Array,
        heard: Heard,
        nodes: dict[str, Node],
        particles: Particles,
        scales: Array,
    ) -> None:
        """Begin the nodes without a place where the map has them; their ranges have told how it lies."""
        count = particles.count
        frames, evidence = np.empty((3, count)), np.empty(count)
        turn_variance = _ANY_TURN if self._turn_sd_rad is None else self._turn_sd_rad**2
        placed = np.trace(heard.spreads, axis1=1, axis2=2) / 2.0
        align_by_ranges(
            heard.places, heard.antennas, heard.ranges_m, heard.noises, placed, scales, frame,
            turn_variance, particles.normal(3, count), frames, evidence,
        )  # fmt: skip
        particles.weigh(np.maximum(evidence - evidence.max(), -_MOST_NATS))
        for tag_id, place, spread in zip(other.ids, other.places, other.spreads, strict=True):
            node = nodes.setdefault(tag_id, Node())
            if not node.is_placed:
                node.gathered = Gathered()
                self._begin(node, place, spread, frames, scales)
                self._taken[writer, tag_id] = spread

    def _take(
        self,
        writer: str,
        found: MapFit,
        prior: Array | None,
        nodes: dict[str, Node],
        particles: Particles,
        scales: Array,
    ) -> None:
        if not any(
            self._is_news(writer, *each, nodes)
            for each in zip(found.other.ids, found.other.spreads, strict=True)
        ):
            return
        count = particles.count
        agreed = found.other.of(found.agreed)
        blocks = np.array([_likely_block(nodes[tag_id], particles.weights) for tag_id in found.agreed])
        blocks = blocks.reshape(-1, ROWS, count)
        frames, evidence = np.empty((3, count)), np.empty(count)
        noise = particles.normal(3, count)
        start = found.frame if self._turn_sd_rad is None else found.frame * [1.0, 1.0, 0.0]
        if prior is None:
            prior = np.diag(
                [0.0, 0.0, 1.0 / _ANY_TURN if self._turn_sd_rad is None else self._turn_sd_rad**-2]
            )
        align(blocks, scales, agreed.places, agreed.spreads, start, prior, noise, frames, evidence)
        if any(each == writer for each, _ in self._taken):  # later maps of it say the same once more
            evidence[:] = 0.0
        for tag_id, place, spread in zip(
            found.other.ids, found.other.places, found.other.spreads, strict=True
        ):
            node = nodes.setdefault(tag_id, Node())
            if not node.is_placed:
                evidence += self._begin(node, place, spread, frames, scales)
                self._taken[writer, tag_id] = spread
            elif tag_id in found.agreed and self._is_news(writer, tag_id, spread, nodes):
                self._tell(writer, tag_id, node, place, spread, frames, scales)
        particles.weigh(np.maximum(evidence - evidence.max(), -_MOST_NATS))

    def _is_news(self, writer: str, tag_id: str, spread: Array, nodes: dict[str, Node]) -> bool:
        """Tell whether a place was not taken yet, or not nearly so well known."""
        before = self._taken.get((writer, tag_id))
        if before is None or tag_id not in nodes or not nodes[tag_id].is_placed:
            return True
        return bool(np.trace(spread) < _TWICE * np.trace(before))

    def _begin(self, node: Node, place: Array, spread: Array, frames: Array, scales: Array) -> Array:
        """Begin a node where the map has it, then take in the ranges that were gathered of it.

        Return the log-likelihoods (M,) of those.
        """
        fits = np.zeros(frames.shape[1])
        block = np.empty((ROWS, frames.shape[1]))
        begin(block, place, spread, frames, self._config.offset_sd_m**2)
        node.blocks, node.log_shares = [block], np.zeros((1, frames.shape[1]))
        gathered, node.gathered = node.gathered, Gathered()
        outliers = (self._config.outlier_share, self._config.outlier_reach_m)
        for range_m, noise, antennas in zip(
            gathered.ranges_m, gathered.noises, gathered.antennas, strict=True
        ):
            works, total = node.see(scales, antennas, range_m, noise, outliers)
            node.correct(scales, works, total)
            fits += total
        return fits

    def _tell(
        self,
        writer: str,
        tag_id: str,
        node: Node,
        place: Array,
        spread: Array,
        frames: Array,
        scales: Array,
    ) -> None:
        before = self._taken.get((writer, tag_id))
        news = spread
        if before is not None:
            news = np.linalg.inv(np.linalg.inv(spread) - 0.99 * np.linalg.inv(before))
            if np.linalg.eigvalsh(news)[0] <= 0.0:
                return  # it became surer in one direction and less so in another: no measurement does that
        self._taken[writer, tag_id] = spread
        fits = np.empty((len(node.blocks), frames.shape[1]))
        for block, each in zip(node.blocks, fits, strict=True):
            told(block, scales, place, news, frames, each)
        if len(node.blocks) > 1:
            node.log_shares += fits
            node.log_shares -= np.logaddexp.reduce(node.log_shares, axis=0)


def _likely_block(node: Node, weights: Array) -> Array:
    if len(node.blocks) == 1:
        return node.blocks[0]
    return node.blocks[int(np.argmax(np.exp(node.log_shares) @ weights))]
