"""Where somebody is who hears a few nodes whose places are known, by how far off each of them sounds.

The probability of each place on a grid, drawn finer and finer round what is left of it (``places.py``):
rings, two places that mirror each other and what walls take away need no approximation. The phone has the
same in ``web/static/phone/locating.js``; both are held to ``tests/vectors/node_places.json``.

A range m to a node at distance d, through w walls that take c each (in ln d):
    by signal:  ln m ~ N(ln d + c w + g + e ln d, s(d)^2 + f^2 + (node's sd / d)^2 + v c^2 (w + 1/2))
    in metres:  m ~ N(d, sd^2 + (node's sd)^2)
g ~ N(0, gain^2) is the receiver's gain, e ~ N(0, exponent^2) how this building differs: common to all
readings, integrated out (Woodbury). The shadowing s(d) is of link and place and stays however often a node is
heard; the fading f averages out. v: a wall takes more or less, and the map shows some that are none and lacks
others. A place has no say of its own but by the plan: who walks is seldom where nobody looked, or in a wall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import exp, hypot, log, sqrt

import numpy as np
from numpy.typing import NDArray

from robots.estimation.radio.likelihood import CELLS, costs_on
from robots.estimation.radio.model import NEAREST_M
from robots.estimation.radio.places import Place, drawn, places_of
from robots.se2 import Array

MOST = 12  # readings that are looked at, the nearest
_BEYOND_SD = 3.0
_FITS_SD = 4.0
_RING_STEPS = 400
_NOWHERE = (0.0, 0.0, 1.0, -1.0)


@dataclass(frozen=True, slots=True)
class Heard:
    """A node in metres of the plan, ``place_sd_m`` along each axis, and how far off it sounds.

    ``log_sd``: of the range's logarithm, by signal, without shadowing; 0 for one in metres, with ``sd_m``.
    """

    node_id: str
    x_m: float
    y_m: float
    place_sd_m: float
    range_m: float
    log_sd: float
    sd_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Since:
    """Where they were for certain, and how far they can have walked since; ``sd_m`` of both together."""

    x_m: float
    y_m: float
    sd_m: float
    at_most_m: float


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Classes uint8 (h, w) of the plan, 0 unknown, 1 free, 2 wall; row 0 at the lowest y."""

    classes: NDArray[np.uint8]
    origin_m: tuple[float, float]
    resolution_m: float


@dataclass(frozen=True, slots=True)
class Radio:
    """What all readings share, in ln d; ``exponent_sd`` is a share; the shadowing as in ``RadioConfig``."""

    gain_sd: float
    wall: float
    reach_m: float
    exponent_sd: float = 0.0
    distances_m: tuple[float, ...] = (0.0,)
    shadow_sds: tuple[float, ...] = (0.0,)

    def log_sd(self, distance_m: float) -> float:
        """Return the deviation in ln d of a signal from so far, but for its fading."""
        shadow = float(np.interp(distance_m, self.distances_m, self.shadow_sds))
        return hypot(shadow, self.gain_sd, self.exponent_sd * log(max(distance_m, NEAREST_M)))


@dataclass(frozen=True, slots=True)
class Ring:
    """All round a node, so far off."""

    node_id: str
    range_m: float
    sd_m: float


@dataclass(frozen=True, slots=True)
class Located:
    """Places, the most probable first, or a ring; ``left_out`` contradicts all others; what agrees fits."""

    places: tuple[Place, ...]
    ring: Ring | None = None
    left_out: str | None = None
    fits: bool = True


def locate(
    heard: Sequence[Heard], radio: Radio, since: Since | None = None, plan: Plan | None = None
) -> Located:
    """Return where one may be who hears these nodes, each of them once.

    Raises:
        ValueError: there is no reading, or a number is not finite.
    """
    nearest = sorted(heard, key=lambda each: (each.range_m, each.node_id))[:MOST]
    if not nearest:
        raise ValueError("nothing was heard of a node whose place is known")
    if not np.isfinite(_rows(nearest)).all():
        raise ValueError("a range or a node's place is no finite number")
    if len(nearest) == 1 and since is None:
        return Located((), _ring(nearest[0], radio))
    found, cost = _places(nearest, radio, since, plan)
    if cost <= _most_cost(len(nearest)):
        return Located(found)
    if len(nearest) > 3:
        tries = [
            (*_places([h for h in nearest if h is not out], radio, since, plan)[::-1], out.node_id)
            for out in nearest
        ]
        best = min(tries, key=lambda each: (each[0], each[2]))
        if best[0] <= _most_cost(len(nearest) - 1):
            return Located(best[1], None, best[2])
    wider = cost / max(1, len(nearest) - 2)
    return Located(tuple(_widened(place, wider) for place in found), fits=False)


def _places(
    heard: Sequence[Heard], radio: Radio, since: Since | None, plan: Plan | None
) -> tuple[tuple[Place, ...], float]:
    """Return the places that fit, and what the readings cost (chi-square) at the best."""
    rows = _rows(heard)
    cells = drawn(lambda box: _costs(rows, radio, since, plan, box), _box(rows, radio, since))
    return places_of(cells), _chi2(rows, radio, plan, cells[int(np.argmin(cells[:, 4]))])


def _box(rows: Array, radio: Radio, since: Since | None) -> Array:
    """Return what the readings and the way since allow: lowest x and y, size of a cell."""
    spread = np.array([hypot(row[4], radio.log_sd(row[3])) if row[4] > 0.0 else 0.0 for row in rows])
    reach = rows[:, 3] * np.exp(_BEYOND_SD * spread) + _BEYOND_SD * (rows[:, 5] + rows[:, 2]) + NEAREST_M
    reach = np.where(rows[:, 4] > 0.0, np.minimum(reach, 3.0 * radio.reach_m), reach)
    middles, halves = rows[:, :2], reach
    if since is not None:
        middles = np.vstack([middles, (since.x_m, since.y_m)])
        halves = np.append(halves, since.at_most_m + _BEYOND_SD * since.sd_m + NEAREST_M)
    low, high = (middles - halves[:, None]).max(axis=0), (middles + halves[:, None]).min(axis=0)
    if (high <= low).any():  # they contradict each other
        k = int(np.argmin(halves))
        low, high = middles[k] - halves[k], middles[k] + halves[k]
    return np.concatenate([low, (high - low) / CELLS])


def _costs(rows: Array, radio: Radio, since: Since | None, plan: Plan | None, box: Array) -> Array:
    told = _NOWHERE if since is None else (since.x_m, since.y_m, since.sd_m, since.at_most_m)
    return np.asarray(costs_on(rows, box, *_shared(radio), told, *_arrays(plan), True))


def _chi2(rows: Array, radio: Radio, plan: Plan | None, cell: Array) -> float:
    """Return what the readings alone cost at a cell: middle, size along x and y."""
    here = np.concatenate([cell[:2] - cell[2:4] / 2.0, cell[2:4]])
    return float(costs_on(rows, here, *_shared(radio), _NOWHERE, *_arrays(plan), False)[0, 0])


def _shared(radio: Radio) -> tuple[tuple[float, float, float, float], Array]:
    shared = (radio.gain_sd, radio.wall, radio.reach_m, radio.exponent_sd)
    return shared, np.array([radio.distances_m, radio.shadow_sds])


def _arrays(plan: Plan | None) -> tuple[NDArray[np.uint8], tuple[float, float, float]]:
    if plan is None:
        return np.zeros((1, 1), np.uint8), (0.0, 0.0, 0.0)
    return plan.classes, (*plan.origin_m, plan.resolution_m)


def _ring(heard: Heard, radio: Radio) -> Ring:
    """Return how far off a node is: of all distances within reach, each alike, as it sounds."""
    if heard.log_sd <= 0.0:
        return Ring(heard.node_id, heard.range_m, hypot(heard.sd_m, heard.place_sd_m))
    centre = min(max(heard.range_m, NEAREST_M), radio.reach_m)
    s = hypot(heard.log_sd, radio.log_sd(centre))
    furthest = min(radio.reach_m, centre * exp(5.0 * s))
    total = first = second = 0.0
    for k in range(_RING_STEPS):
        d = (k + 0.5) * furthest / _RING_STEPS
        weight = exp(-0.5 * (log(centre / d) / s) ** 2)
        total, first, second = total + weight, first + weight * d, second + weight * d * d
    mean = first / total
    return Ring(heard.node_id, mean, hypot(sqrt(max(second / total - mean * mean, 0.0)), heard.place_sd_m))


def _rows(heard: Sequence[Heard]) -> Array:
    return np.array(
        [[h.x_m, h.y_m, h.place_sd_m, max(h.range_m, NEAREST_M), h.log_sd, h.sd_m] for h in heard]
    )


def _most_cost(readings: int) -> float:
    free = max(1, readings - 2)
    return free + _FITS_SD * sqrt(2.0 * free)


def _widened(place: Place, by: float) -> Place:
    wide = max(by, 1.0)
    return replace(place, var_x=wide * place.var_x, var_xy=wide * place.var_xy, var_y=wide * place.var_y)
