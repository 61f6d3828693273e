"""Beam search for the way through stations that has most new ground in sight, the sooner the better.

That is orienteering with coverage. Ways are kept by their length, metre by metre: of those equally long the
ones with most ground go on, a few to each station, so that none crowds out all others.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robots.exploration.strategies.tours.stations import MOST_NEIGHBOURS, Indices
from robots.se2 import Array

_KEPT_LEVELS = 4  # a step is at most so many metres long, less one
_ONE = np.uint64(1)
_TURN_M2 = 0.1  # product of two steps: about 95 degrees where they are 1 m long


@njit(cache=True)
def best_way(
    places: Array, ends: Indices, ways: Array, first: NDArray[np.int64], seen: Indices, worth: Array,
    longest: int, width: int, per_station: int, fades: float,
) -> tuple[Indices, Array, Array]:  # fmt: skip
    """Return the way from the last station on that gains most; of equals the shortest.

    Args:
        places: of ``Stations``, as are the next four.
        ends: see there.
        ways: ``ways_m``.
        first: where each station's cells begin.
        seen: the cells.
        worth: of each coarse cell, (c,): counted once, however often it is in sight.
        longest: metres; no way is longer.
        width: ways that are kept for each metre of length.
        per_station: of these with the same end.
        fades: metres of way after which what is gained would count for nothing: the sooner, the better.

    Returns:
        The stations (k,), the first of them the start, what was gained and how long the way was at each (k,).
    """
    words, most = (len(worth) + 63) // 64, longest + 1
    at = np.full((most, width), -1, np.int32)
    before = np.full((most, width, 2), -1, np.int32)
    gain, length = np.zeros((most, width)), np.zeros((most, width))
    cover = np.zeros((_KEPT_LEVELS, width, words), np.uint64)
    room = width * MOST_NEIGHBOURS * (_KEPT_LEVELS - 1)
    next_at = np.zeros((_KEPT_LEVELS, room), np.int32)
    next_before = np.zeros((_KEPT_LEVELS, room, 2), np.int32)
    next_gain, next_length = np.zeros((_KEPT_LEVELS, room)), np.zeros((_KEPT_LEVELS, room))
    waiting = np.zeros(_KEPT_LEVELS, np.int64)
    next_at[0, 0], next_before[0, 0], waiting[0] = len(ends) - 1, -1, 1
    used = np.zeros(len(ends), np.int32)
    best, best_level, best_k = -np.inf, 0, 0
    for level in range(most):
        ring, count = level % _KEPT_LEVELS, 0
        values = next_gain[ring, : waiting[ring]]
        order = np.argsort(-values, kind="mergesort")
        used[:] = 0
        for k in order:
            station = next_at[ring, k]
            if count == width:
                break
            if used[station] == per_station:
                continue
            used[station] += 1
            at[level, count], before[level, count] = station, next_before[ring, k]
            gain[level, count], length[level, count] = next_gain[ring, k], next_length[ring, k]
            from_level, from_k = before[level, count]
            if from_level >= 0:
                cover[ring, count] = cover[from_level % _KEPT_LEVELS, from_k]
            else:
                cover[ring, count] = 0
            for cell in seen[first[station] : first[station + 1]]:
                cover[ring, count, cell >> 6] |= _ONE << np.uint64(cell & 63)
            if values[k] > best + 1e-9:
                best, best_level, best_k = values[k], level, count
            count += 1
        waiting[ring] = 0
        for k in range(count):
            station, back = at[level, k], -1
            if before[level, k, 0] >= 0:
                back = at[before[level, k, 0], before[level, k, 1]]
            for d in range(MOST_NEIGHBOURS):
                to = ends[station, d]
                if to < 0 or (back >= 0 and turns_back(places[back], places[station], places[to])):
                    continue
                far = length[level, k] + ways[station, d]
                next_level = max(level + 1, int(far))
                if next_level >= most or next_level >= level + _KEPT_LEVELS:
                    continue
                total, fresh = gain[level, k], 0.0
                for cell in seen[first[to] : first[to + 1]]:
                    if not (cover[ring, k, cell >> 6] >> np.uint64(cell & 63)) & _ONE:
                        fresh += worth[cell]
                total += fresh * max(0.0, 1.0 - far / fades)
                next_ring = next_level % _KEPT_LEVELS
                n = waiting[next_ring]
                next_at[next_ring, n] = to
                next_before[next_ring, n, 0], next_before[next_ring, n, 1] = level, k
                next_gain[next_ring, n], next_length[next_ring, n] = total, far
                waiting[next_ring] = n + 1
    found: tuple[Indices, Array, Array] = _trace(at, before, gain, length, best_level, best_k)
    return found


@njit(cache=True)
def turns_back(before: Array, at: Array, after: Array) -> bool:
    """Return whether a way by three places turns by much more than 90 degrees.

    Who follows a way goes on from the point of it that is nearest, so it must not lie on itself.
    """
    product = (at[0] - before[0]) * (after[0] - at[0]) + (at[1] - before[1]) * (after[1] - at[1])
    return bool(product < -_TURN_M2)


@njit(cache=True)
def _trace(
    at: Indices, before: Indices, gain: Array, length: Array, level: int, k: int
) -> tuple[Indices, Array, Array]:
    stations = np.empty(len(at), np.int32)
    gains, lengths = np.empty(len(at)), np.empty(len(at))
    count = 0
    while level >= 0:
        stations[count] = at[level, k]
        gains[count], lengths[count] = gain[level, k], length[level, k]
        count += 1
        level, k = before[level, k, 0], before[level, k, 1]
    return stations[:count][::-1].copy(), gains[:count][::-1].copy(), lengths[:count][::-1].copy()
