"""EKF-SLAM over tags that are known by their ids (Ziparo 2007 section 4): the filter behind ``FilterSlam``.

Two beliefs run side by side once another robot's map was read: the robot's own, from its own measurements
alone, which is what it leaves in memories; and the joined one, made of the own and the newest map of each
other robot. A newer map makes a new joined belief, so nothing is ever counted twice.
"""

from __future__ import annotations

from math import exp, inf

import numpy as np

from robots.config import AgentConfig, EkfConfig
from robots.estimation.ekf.anchors import HungAnchors
from robots.estimation.ekf.maps import join_map, own_map, tag_belief
from robots.estimation.ekf.state import TagState
from robots.estimation.ekf.trust import TagTrust, plausible, plausible_belief
from robots.estimation.ekf.waiting import WaitingRoom, range_of
from robots.estimation.radio.cones import Crossing, edge_of
from robots.estimation.tag_filter import RangeSighting
from robots.se2 import Array, GaussianPose, Pose2
from robots.tags.map_memory import TagBelief, WriterMap

_BEAM_RAD, _RANGE_SHARE = 0.15, 0.3  # a sighting this narrow tells a place at once
_SAME_S = 0.01  # sightings of a tag are no nearer in time than this
_UNKNOWN = 1e12  # variance (m2)
_EVERY_S = 5.0  # maps are made and joined anew no more often


class EkfFilter:
    """Pose and tags of one robot: the protocol ``TagFilter``."""

    range_scale = 1.0

    def __init__(self, robot_id: str, config: AgentConfig, start: Pose2) -> None:
        self._config: EkfConfig = config.ekf
        self._own = TagState(start)
        self._joined: TagState | None = None
        self._trust, self._joined_trust = TagTrust(), TagTrust()
        self._waiting = WaitingRoom(config.ekf.place_sd_m)
        self._anchors = HungAnchors(start)
        self._recent: list[str] = []  # tags seen last, the newest first
        self._seen_s: dict[str, float] = {}
        self._now_s = -inf
        self._maps: dict[str, WriterMap] = {}
        self._stale: dict[str, None] = {}  # tags that others' maps have where they are no more
        self._pending = False  # a map waits to be joined
        self._joined_s = -inf
        self._left: tuple[float, tuple[TagBelief, ...]] = (-inf, ())
        self._doubts: list[str] = []
        self._told: dict[str, None] = {}

    @property
    def belief(self) -> GaussianPose:
        """The robot's pose."""
        return self._best.belief

    def predict(self, moved: GaussianPose) -> None:
        """Move by a displacement in the frame of the pose before, with its covariance (3, 3)."""
        self._waiting.move(moved)
        for state in self._states():
            state.move(moved)

    def see_heading(self, heading_rad: float, sd_rad: float) -> None:
        """Take in the heading of a compass."""
        for state in self._states():
            state.see_heading(heading_rad, sd_rad)

    def see(self, sighting: RangeSighting) -> bool:
        """Take in a sighting of a tag; say whether it was used, or waits to be."""
        tag_id, now_s = sighting.tag_id, sighting.stamp_s
        if not plausible(sighting):
            self._doubt(
                f"Tag {tag_id} was heard at an impossible range or bearing; such sightings are left out."
            )
            return False
        if self._trust.is_banned(tag_id):
            return False
        self._now_s = max(self._now_s, now_s)
        self._recent = [tag_id, *(t for t in self._recent if t != tag_id)][:2]
        thin = self._thinning(sighting)
        if tag_id in self._own:
            self._correct(self._own, self._trust, sighting, thin)
            place = None
        else:
            place = self._place(sighting)
        if self._joined is not None and tag_id in self._joined:
            self._correct(self._joined, self._joined_trust, sighting, thin)
        if place is not None:
            for state in self._states():
                if tag_id not in state:
                    state.add(tag_id, *place)
            self._pending |= any(tag_id in _ids(each) for each in self._maps.values())
        self._join_when_due()
        return True

    def see_crossing(self, crossing: Crossing) -> None:
        """Take in that a tag came into the cone of an antenna or left it."""
        for state in self._states():
            if crossing.tag_id not in state or self._trust.is_banned(crossing.tag_id):
                continue
            first, middle, last = (
                state.expect(crossing.tag_id, pose.as_array())
                for pose in (crossing.base_from_first, crossing.base_from_middle, crossing.base_from_last)
            )
            told = edge_of(crossing, first, middle, last)
            if told is not None:
                seen = np.array([middle.range_m, _UNKNOWN, *told, 0.0])
                antenna = crossing.base_from_middle.as_array()
                state.see(crossing.tag_id, antenna, seen, 1.0, self._config.gate_sd**2)

    def anchor(self) -> None:
        """Remember the pose here as a vertex of the graph."""
        self._anchors.add(self.belief.mean, self._recent, self._best)

    def anchors(self) -> list[Pose2]:
        """Return all poses remembered, as they are believed now; the first is the start."""
        return self._anchors.poses(self._best)

    def tags(self) -> dict[str, TagBelief]:
        """Return the tags whose places are known so far, as they were when last near."""
        return {tag_id: tag_belief(tag_id, *self._best.place(tag_id)) for tag_id in self._best.tag_ids}

    def range_offset(self, tag_id: str) -> float:
        """Return 0: ranges are taken as they come."""
        return 0.0

    def own_map(self) -> tuple[TagBelief, ...]:
        """Return the tags as this robot's own measurements alone have them, some seconds old at most."""
        made_s, beliefs = self._left
        if self._now_s > made_s + _EVERY_S or len(beliefs) != len(self._own.tag_ids):
            beliefs = own_map(self._own)
            self._left = (self._now_s, beliefs)
        return beliefs

    def read_map(self, other: WriterMap) -> None:
        """Take in a map that another robot left: a newer one of a writer stands for its older ones."""
        known = self._maps.get(other.writer)
        if known is not None and known.revision >= other.revision:
            return
        self._maps[other.writer] = self._checked(other)
        self._pending = True
        if known is None:
            self._joined_s = -inf  # a new robot's map does not wait
        self._join_when_due()

    def take_doubts(self) -> tuple[str, ...]:
        """Return, once, what is wrong with tags, ranges and maps, each in a sentence for the operator."""
        doubts, self._doubts = tuple(self._doubts), []
        return doubts

    @property
    def _best(self) -> TagState:
        return self._own if self._joined is None else self._joined

    def _states(self) -> tuple[TagState, ...]:
        return (self._own,) if self._joined is None else (self._own, self._joined)

    def _thinning(self, sighting: RangeSighting) -> float:
        """Return how many times a sighting's variances count, since errors last.

        Errors that fade as exp(-t / T) tell as much as white ones whose variance is (1 + rho) / (1 - rho)
        times as large, with rho = exp(-dt / T).
        """
        last_s = self._seen_s.get(sighting.tag_id)
        self._seen_s[sighting.tag_id] = sighting.stamp_s
        if last_s is None or self._config.error_lasts_s <= 0.0:
            return 1.0
        rho = exp(-max(sighting.stamp_s - last_s, _SAME_S) / self._config.error_lasts_s)
        return (1.0 + rho) / (1.0 - rho)

    def _correct(self, state: TagState, trust: TagTrust, sighting: RangeSighting, thin: float) -> None:
        tag_id = sighting.tag_id
        antenna, seen = _numbers(sighting)
        if sighting.in_cone:
            seen[3] = inf  # the same at every sighting from one side: ``see_crossing`` tells the bearing
        if sighting.independent:  # of the range alone: a cone tells the same at every sighting from one side
            seen[3] *= thin
            thin = 1.0
        distance = state.see(tag_id, antenna, seen, thin, self._config.gate_sd**2)
        if not trust.judge(tag_id, sighting.stamp_s, distance):
            return
        self._stale[tag_id] = None
        if state is self._joined:
            self._doubt(
                f"Tag {tag_id} is not where other robots' maps have it; their word on it is left out."
            )
            self._pending, self._joined_s = True, -inf
            return
        state.forget(tag_id)
        self._waiting.leave(tag_id)
        self._seen_s.pop(tag_id, None)
        self._pending, self._joined_s = bool(self._maps), -inf
        if trust.is_banned(tag_id):
            self._doubt(
                f"Two tags seem to answer to the id {tag_id}, or it is carried about; it is not used."
            )
        else:
            self._doubt(f"Tag {tag_id} is not where it was; its place is learnt anew.")

    def _place(self, sighting: RangeSighting) -> tuple[tuple[float, float], Array] | None:
        """Return where an unknown tag is in the base frame, with covariance; None while that is not known."""
        if sighting.dropped is not None:
            return sighting.dropped.place_m, sighting.dropped.covariance
        bearing, sd = sighting.bearing_rad, sighting.bearing_sd_rad
        if bearing is None or sd is None or sd > _BEAM_RAD:
            return self._waiting.add(sighting)
        if sighting.range_sd_m > _RANGE_SHARE * sighting.range_m and sighting.range_sd_m > 0.1:
            return self._waiting.add(sighting)
        antenna = sighting.base_from_antenna
        c, s = np.cos(antenna.theta + bearing), np.sin(antenna.theta + bearing)
        turned = np.array([[c, -s], [s, c]])
        spread = turned @ np.diag([sighting.range_sd_m**2, (sd * sighting.range_m) ** 2]) @ turned.T
        return (antenna.x + c * sighting.range_m, antenna.y + s * sighting.range_m), spread

    def _checked(self, other: WriterMap) -> WriterMap:
        good = tuple(b for b in other.beliefs if plausible_belief(b))
        ids = [b.tag_id for b in good]
        once = tuple(b for b in good if ids.count(b.tag_id) == 1) if len(set(ids)) < len(ids) else good
        if len(once) < len(other.beliefs):
            bad = len(other.beliefs) - len(once)
            self._doubt(
                f"The map that {other.writer} left has impossible or repeated places for {bad} tags;"
                " they are left out."
            )
        return WriterMap(other.writer, other.revision, once)

    def _join_when_due(self) -> None:
        if not self._pending or self._now_s < self._joined_s + _EVERY_S:
            return
        self._pending, self._joined_s = False, self._now_s
        joined, any_joined = self._own.copy(), False
        for writer in sorted(self._maps):
            beliefs = self._maps[writer].beliefs
            outcome = join_map(joined, tuple(b for b in beliefs if b.tag_id not in self._stale))
            any_joined |= outcome.aligned
            if outcome.foreign:
                self._doubt(
                    f"The map that {writer} left does not fit the tags here, as if from another mission;"
                    " it is left out."
                )
            for tag_id in outcome.elsewhere:
                self._doubt(
                    f"Tag {tag_id} lies elsewhere in the map that {writer} left; it may have been moved."
                )
        self._joined = joined if any_joined else None
        self._joined_trust = TagTrust()

    def _doubt(self, text: str) -> None:
        if text not in self._told:
            self._told[text] = None
            self._doubts.append(text)


def _numbers(sighting: RangeSighting) -> tuple[Array, Array]:
    bearing, sd = sighting.bearing_rad, sighting.bearing_sd_rad
    variance = inf if bearing is None or sd is None else sd**2
    range_m, log_sd = range_of(sighting)
    seen = np.array([range_m, sighting.range_sd_m**2, bearing or 0.0, variance, log_sd])
    return sighting.base_from_antenna.as_array(), seen


def _ids(each: WriterMap) -> set[str]:
    return {belief.tag_id for belief in each.beliefs}
