"""Maps that other robots left, joined to the filter's own, and the own one made fit to be left.

A map comes as places in the frame of its writer, each with a covariance. How that frame lies is not known
and taken from the tags both have: the map tells of the state only what no motion of its frame can explain,
so the residuals are projected on the null space of those three (as in Mourikis and Roumeliotis 2007). Tags
that only the writer has hang on the frame so found.

A memory has no room for how the errors of two tags go together. ``own_map`` therefore leaves covariances
under which errors that are independent cover those that are not: what a motion of the whole map explains is
taken out, since every reader has to find the frame, and the rest is scaled up until it is a bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.stats import chi2

from robots.estimation.ekf.kernels import HEAD, retract
from robots.estimation.ekf.state import TagState
from robots.se2 import Array
from robots.tags.map_memory import TagBelief

_MOST_COMMON = 100  # tags that align a map, those nearest to the robot
_CHANCE = 1e-6  # of a map that is right to be taken for a wrong one
_TURN_SD_RAD = 0.2  # a frame found no better than this waits for more common tags
_LEAST_SD_M = 0.005  # of a place: nobody knows better
_POWER_STEPS = 30


@dataclass(frozen=True, slots=True)
class Joined:
    """How a map fitted: not ``aligned`` yet, ``foreign``, or joined but for the tags it has ``elsewhere``."""

    aligned: bool = False
    foreign: bool = False
    elsewhere: tuple[str, ...] = ()


def join_map(state: TagState, beliefs: tuple[TagBelief, ...]) -> Joined:
    """Take in the places of another robot's map, each tag once; the state changes only if they are joined."""
    names = state.tag_ids
    mean, cov = state.whole()
    known = {name: HEAD + 2 * k for k, name in enumerate(names)}
    common = [belief for belief in beliefs if belief.tag_id in known]
    if len(common) > _MOST_COMMON:
        away = [np.hypot(*(mean[known[b.tag_id] : known[b.tag_id] + 2] - mean[1:3])) for b in common]
        common = [common[k] for k in np.argsort(away, kind="stable")[:_MOST_COMMON]]
    elsewhere: list[str] = []
    while len(common) >= (3 if elsewhere else 2):
        at = np.array([[known[b.tag_id], known[b.tag_id] + 1] for b in common]).ravel()
        fit = _Fit.of(mean[at].reshape(-1, 2), cov[np.ix_(at, at)], common)
        if fit.turn_sd_rad > _TURN_SD_RAD:
            return Joined()
        worst = fit.worst()
        if worst is None:
            _correct(mean, cov, at, fit)
            others = [b for b in beliefs if b.tag_id not in known]
            state.set_whole(names + [b.tag_id for b in others], *_grown(mean, cov, at, common, others))
            return Joined(True, elsewhere=tuple(elsewhere))
        elsewhere.append(common.pop(worst).tag_id)
        if len(elsewhere) > len(common):
            break
    return Joined(foreign=bool(elsewhere))


def own_map(state: TagState) -> tuple[TagBelief, ...]:
    """Return the tags with covariances that bound their errors, taken as independent, in any frame."""
    names = state.tag_ids
    if not names:
        return ()
    mean, cov = state.whole()
    places = mean[HEAD:].reshape(-1, 2)
    spreads = _bound(places, cov[HEAD:, HEAD:])
    return tuple(
        tag_belief(name, place, spread) for name, place, spread in zip(names, places, spreads, strict=True)
    )


def tag_belief(tag_id: str, place: Array, spread: Array) -> TagBelief:
    """Return the belief of a place (2,) with covariance (2, 2)."""
    x, y = place.tolist()
    return TagBelief(tag_id, x, y, float(spread[0, 0]), float(spread[0, 1]), float(spread[1, 1]))


def covariance(belief: TagBelief) -> Array:
    """Return the covariance (2, 2) of a place."""
    return np.array(
        [[belief.variance_x, belief.covariance_xy], [belief.covariance_xy, belief.variance_y]], np.float64
    )


class _Fit:
    """The frame of a map, ``turn`` (2, 2) and ``shift_m`` (2,), that fits best, and what is left over."""

    def __init__(self, places: Array, cov: Array, beliefs: list[TagBelief], turn: Array, shift_m: Array):
        self.there = _places(beliefs)
        self.turn, self.shift_m = turn, shift_m
        self.spreads = turn @ _spreads(beliefs) @ turn.T
        self.noise = _block_diagonal(self.spreads)
        self.by_frame = _rigid(places)
        self.off = (places - self.there @ turn.T - shift_m).ravel()
        self.free = np.linalg.qr(self.by_frame, mode="complete")[0][:, 3:]  # N: N.T @ by_frame = 0
        total = cov + self.noise
        self.root = cholesky(self.free.T @ total @ self.free, lower=True)
        self.turn_sd_rad = float(
            np.sqrt(np.linalg.inv(self.by_frame.T @ np.linalg.solve(total, self.by_frame))[2, 2])
        )

    @classmethod
    def of(cls, places: Array, cov: Array, beliefs: list[TagBelief]) -> _Fit:
        """Fit by weighted least squares (Horn 1987), weights by the sum of both variances."""
        spreads = _spreads(beliefs)
        sums = np.trace(spreads, axis1=1, axis2=2) + np.diag(cov).reshape(-1, 2).sum(axis=1)
        weights = (1.0 / sums) / (1.0 / sums).sum()
        there = _places(beliefs)
        a, b = weights @ there, weights @ places
        moment = ((there - a) * weights[:, None]).T @ (places - b)
        angle = np.arctan2(moment[0, 1] - moment[1, 0], moment[0, 0] + moment[1, 1])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return cls(places, cov, beliefs, turn, b - turn @ a)

    def worst(self) -> int | None:
        """Return the tag whose removal explains most of a misfit (Baarda 1968); None where all fits."""
        left = self.free.T @ self.off
        if not len(left):
            return None
        white = solve_triangular(self.root, left, lower=True)
        if white @ white <= chi2.isf(_CHANCE, len(left)):
            return None
        pull = self.free @ cho_solve((self.root, True), left)
        weight = self.free @ cho_solve((self.root, True), self.free.T)
        gains = []
        for k in range(0, len(pull), 2):
            gain = np.linalg.pinv(weight[k : k + 2, k : k + 2], rcond=1e-9, hermitian=True)
            gains.append(pull[k : k + 2] @ gain @ pull[k : k + 2])
        return int(np.argmax(gains))


def _correct(mean: Array, cov: Array, at: Array, fit: _Fit) -> None:
    """Correct the state by what no motion of the frame explains; ``mean`` and ``cov`` change in place."""
    left = -solve_triangular(fit.root, fit.free.T @ fit.off, lower=True)
    gain = solve_triangular(fit.root, fit.free.T @ cov[at], lower=True)  # (k, n), whitened
    cov -= gain.T @ gain
    retract(mean, len(mean), gain.T @ left)


def _grown(
    mean: Array, cov: Array, at: Array, common: list[TagBelief], others: list[TagBelief]
) -> tuple[Array, Array]:
    """Return the state with the tags that only the map has, hung on its frame."""
    if not others:
        return mean, cov
    places = mean[at].reshape(-1, 2)
    fit = _Fit.of(places, cov[np.ix_(at, at)], common)
    weighted = np.linalg.solve(fit.noise, fit.by_frame).T  # H.T W
    loose = np.linalg.inv(weighted @ fit.by_frame)
    by_common = loose @ weighted  # how the frame goes with the tags it was taken from
    angle = by_common @ fit.off
    turned = np.array([[1.0, -angle[2]], [angle[2], 1.0]])
    found = (_places(others) @ fit.turn.T + fit.shift_m) @ turned.T + angle[:2]
    by_frame = _rigid(found)
    n, k = len(mean), 2 * len(others)
    grown = np.empty((n + k, n + k))
    grown[:n, :n] = cov
    grown[n:, :n] = by_frame @ (by_common @ cov[at])
    grown[:n, n:] = grown[n:, :n].T
    frame = by_common @ cov[np.ix_(at, at)] @ by_common.T + loose
    own = by_frame @ frame @ by_frame.T + _block_diagonal(fit.turn @ _spreads(others) @ fit.turn.T)
    grown[n:, n:] = (own + own.T) / 2.0
    return np.concatenate([mean, found.ravel()]), grown


def _bound(places: Array, cov: Array) -> Array:
    """Return covariances (n, 2, 2) whose independent errors cover ``cov`` but for motions of the map."""
    count = len(places)
    own = np.array([cov[k : k + 2, k : k + 2] for k in range(0, 2 * count, 2)]) + _LEAST_SD_M**2 * np.eye(2)
    rigid = _rigid(places)
    weighted = np.linalg.solve(own, rigid.reshape(count, 2, 3)).reshape(-1, 3).T
    explained = rigid @ np.linalg.pinv(weighted @ rigid, hermitian=True) @ weighted
    left = np.eye(2 * count) - explained
    rest = left @ cov @ left.T
    spreads = np.array([rest[k : k + 2, k : k + 2] for k in range(0, 2 * count, 2)])
    spreads += _LEAST_SD_M**2 * np.eye(2)
    roots = np.linalg.cholesky(spreads)
    vector = np.ones((count, 2, 1)) + 0.01 * np.arange(count)[:, None, None]  # any one not orthogonal
    scale = 1.0
    for _ in range(_POWER_STEPS):  # of the greatest eigenvalue of rest in the measure of the blocks
        vector = vector / np.linalg.norm(vector)
        spread = np.linalg.solve(np.transpose(roots, (0, 2, 1)), vector)
        vector = np.linalg.solve(roots, (rest @ spread.reshape(-1)).reshape(count, 2, 1))
        scale = float(np.linalg.norm(vector))
    return spreads * max(scale, 1.0)


def _rigid(places: Array) -> Array:
    """Return how places (n, 2) move with their frame: x, y, turn about the origin, (2n, 3)."""
    by = np.zeros((len(places), 2, 3))
    by[:, 0, 0] = by[:, 1, 1] = 1.0
    by[:, 0, 2], by[:, 1, 2] = -places[:, 1], places[:, 0]
    return by.reshape(-1, 3)


def _places(beliefs: list[TagBelief]) -> Array:
    return np.array([(b.x_m, b.y_m) for b in beliefs], np.float64).reshape(-1, 2)


def _spreads(beliefs: list[TagBelief]) -> Array:
    least = _LEAST_SD_M**2 * np.eye(2)
    return np.array([covariance(b) + least for b in beliefs])


def _block_diagonal(blocks: Array) -> Array:
    whole = np.zeros((2 * len(blocks), 2 * len(blocks)))
    for k, block in enumerate(blocks):
        whole[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = block
    return whole
