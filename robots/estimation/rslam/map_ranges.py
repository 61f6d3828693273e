"""How another robot's map lies in one's own by ranges alone, before one has placed any of its nodes oneself.

The ranges gathered of three or more of its nodes are enough: the map is turned and moved until they fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from robots.estimation.rslam.map_fit import MapPlaces
from robots.estimation.rslam.nodes import Node
from robots.se2 import Array

_NODES, _RANGES, _WAY_M = 3, 12, 2.0  # fewest nodes, ranges, and way between the first and the last
_TURNS, _SIDE, _BEYOND_M = 24, 10, 10.0  # starts: so many turns, and places on a grid reaching so far beyond
_STARTS, _ROUNDS = 24, 12
_CHANCE = 1e-3
_CLEARER = 12.0  # chi-square by which the second best has to be worse
_SURE_RAD, _SURE_M = 0.35, 4.0


@dataclass(frozen=True, slots=True)
class Heard:
    """Ranges to nodes of one map: their ``places`` and ``spreads`` there, (k, 2) and (k, 2, 2).

    ``antennas`` (k, 2, M) from where each particle measured them, ``means`` (k, 2) the mean of those,
    ``ranges_m`` (k,), ``noises`` (k, 2) as in ``innovations``.
    """

    places: Array
    spreads: Array
    antennas: Array
    means: Array
    ranges_m: Array
    noises: Array

    def variances(self, expected_m: Array, scale_sd: float) -> Array:
        """Return variances of the ranges, the map's and the scale's errors among them."""
        noise = self.noises[:, 0] + self.noises[:, 1] * expected_m
        placed = np.trace(self.spreads, axis1=1, axis2=2) / 2.0
        total: Array = noise**2 + placed + (scale_sd * expected_m) ** 2
        return total


def heard_of(nodes: dict[str, Node], other: MapPlaces) -> Heard | None:
    """Return what was gathered of the nodes in a map; None where it is too little to tell anything."""
    rows: list[tuple[int, int]] = []
    gathered = []
    for number, tag_id in enumerate(other.ids):
        node = nodes.get(tag_id)
        if node is not None and not node.is_placed and not node.ignored and node.gathered.ranges_m:
            believed = np.flatnonzero(node.gathered.believed())
            rows += [(number, int(k)) for k in believed]
            gathered += [node.gathered] * len(believed)
    if len(rows) < _RANGES or len({number for number, _ in rows}) < _NODES:
        return None
    means = np.array([each.mean_antennas[k] for each, (_, k) in zip(gathered, rows, strict=True)])
    if np.ptp(means, axis=0).max() < _WAY_M:
        return None
    of = [number for number, _ in rows]
    return Heard(
        other.places[of],
        other.spreads[of],
        np.array([each.antennas[k] for each, (_, k) in zip(gathered, rows, strict=True)]),
        means,
        np.array([each.ranges_m[k] for each, (_, k) in zip(gathered, rows, strict=True)]),
        np.array([each.noises[k] for each, (_, k) in zip(gathered, rows, strict=True)]),
    )


def locate(heard: Heard, scale: tuple[float, float], turn_sd_rad: float | None) -> Array | None:
    """Return how the map's frame lies, (3,) x, y, turn; None while more than one way is likely."""
    found: list[tuple[float, Array, Array]] = []
    for start in _starts(heard, scale[0], turn_sd_rad):
        found.append(_refined(heard, start, scale, turn_sd_rad))
    found.sort(key=lambda each: each[0])
    cost, frame, information = found[0]
    if cost > chi2.isf(_CHANCE, max(len(heard.ranges_m) - 3, 1)):
        return None
    for other_cost, other, _ in found[1:]:
        turned = (other[2] - frame[2] + np.pi) % (2.0 * np.pi) - np.pi
        apart = np.hypot(*(other[:2] - frame[:2])) > _SURE_M or abs(turned) > _SURE_RAD
        if apart and other_cost - cost < _CLEARER:
            return None
    covariance = np.linalg.inv(information)
    if covariance[2, 2] > _SURE_RAD**2 / 4.0 or covariance[0, 0] + covariance[1, 1] > _SURE_M**2 * 4.0:
        return None
    return frame


def _starts(heard: Heard, scale: float, turn_sd_rad: float | None) -> list[Array]:
    turns = np.linspace(-np.pi, np.pi, _TURNS, endpoint=False) if turn_sd_rad is None else np.zeros(1)
    low, high = heard.places.min(axis=0) - _BEYOND_M, heard.places.max(axis=0) + _BEYOND_M
    x, y = (np.linspace(low[k], high[k], _SIDE) for k in (0, 1))
    spots = np.array([(a, b) for a in x for b in y])  # where the robot is in the other map
    few = np.linspace(0, len(heard.ranges_m) - 1, min(len(heard.ranges_m), 80)).astype(int)
    frames, costs = [], []
    for turn in turns:
        c, s = np.cos(turn), np.sin(turn)
        rotation = np.array([[c, s], [-s, c]])
        moved = heard.means[-1] - spots @ rotation
        off = heard.places[few] @ rotation + moved[:, None] - heard.means[few]
        expected = np.maximum(scale * np.hypot(off[..., 0], off[..., 1]), 0.3)
        sds = heard.noises[few, 0] + heard.noises[few, 1] * heard.ranges_m[few] + 1.0
        misfits = np.minimum(((heard.ranges_m[few] - expected) / sds) ** 2, 9.0).sum(axis=1)
        frames += [np.array([*each, turn]) for each in moved]
        costs += misfits.tolist()
    return [frames[k] for k in np.argsort(costs, kind="stable")[:_STARTS]]


def _refined(
    heard: Heard, start: Array, scale: tuple[float, float], turn_sd_rad: float | None
) -> tuple[float, Array, Array]:
    """Return chi-square, frame and information at the minimum next to a start (Levenberg-Marquardt)."""
    frame, damping = start.copy(), 1.0
    cost, gradient, information = _normal_equations(heard, frame, scale, turn_sd_rad)
    for _ in range(_ROUNDS):
        step = np.linalg.solve(information + damping * np.diag(np.diag(information)), gradient)
        tried = frame + step
        other = _normal_equations(heard, tried, scale, turn_sd_rad)
        if other[0] < cost:
            frame, damping = tried, damping / 5.0
            cost, gradient, information = other
        else:
            damping *= 5.0
    return cost, frame, information


def _normal_equations(
    heard: Heard, frame: Array, scale: tuple[float, float], turn_sd_rad: float | None
) -> tuple[float, Array, Array]:
    c, s = np.cos(frame[2]), np.sin(frame[2])
    turned = heard.places @ np.array([[c, s], [-s, c]])
    off = turned + frame[:2] - heard.means
    distance = np.maximum(np.hypot(off[:, 0], off[:, 1]), 0.1)
    expected = scale[0] * distance
    by_log = heard.noises[:, 1] > 0.0
    residual = np.where(
        by_log, expected * np.log(np.maximum(heard.ranges_m, 0.05) / expected), heard.ranges_m - expected
    )
    variance = heard.variances(expected, scale[1])
    unit = scale[0] * off / distance[:, None]
    by_frame = np.column_stack([unit, -unit[:, 0] * turned[:, 1] + unit[:, 1] * turned[:, 0]])
    weighted = by_frame / variance[:, None]
    information: Array = by_frame.T @ weighted + np.eye(3) * 1e-9
    gradient: Array = weighted.T @ residual
    cost = float(
        (residual**2 / variance + np.where(by_log, 2.0 * np.log(variance**0.5 / expected), 0.0)).sum()
    )
    # of the normaliser only what differs between frames; the noise at the measured range is its reference
    cost -= float(np.where(by_log, 2.0 * np.log(np.maximum(heard.noises[:, 1], 1e-9)), 0.0).sum())
    if turn_sd_rad is not None:
        information[2, 2] += 1.0 / turn_sd_rad**2
        gradient[2] -= frame[2] / turn_sd_rad**2
        cost += frame[2] ** 2 / turn_sd_rad**2
    return cost, gradient, information
