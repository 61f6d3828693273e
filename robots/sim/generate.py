"""Generated worlds: an office floor (corridors, rooms, furniture) and an open hall (pillars, debris)."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, sin, sqrt

import numpy as np
from scipy import ndimage

from robots.sim.floor import FloorPlan
from robots.sim.world import Mask, World, WorldError, world_of

RESOLUTION_M = 0.05
_BODY_M = 0.30  # what may be generated as free leaves room for a body of this radius
_TOLERANCE = 0.02
_ROUNDS = 12
SMALLEST_M2, LARGEST_M2 = 30.0, 20_000.0


def generate(kind: str, area_m2: float, rng: np.random.Generator) -> World:
    """Return a world of about ``area_m2`` free floor (within 3 %), all of it connected.

    Raises:
        WorldError: the kind is neither "office" nor "open", or the area is out of range.
    """
    builders: dict[str, Callable[[float, np.random.Generator], Mask]] = {"office": _office, "open": _hall}
    if kind not in builders:
        raise WorldError(f"there are no {kind!r} worlds; use office:AREA, open:AREA or a map's YAML file")
    if not SMALLEST_M2 <= area_m2 <= LARGEST_M2:
        raise WorldError(
            f"{kind}:{area_m2:g} is out of range; give {SMALLEST_M2:g} to {LARGEST_M2:g} square metres"
        )
    layout_seed = int(rng.integers(2**62))
    gross_m2 = 1.25 * area_m2
    best: Mask | None = None
    best_error = np.inf
    for attempt in range(_ROUNDS):
        # the same draws on a slightly larger or smaller floor; another layout when that does not settle
        solid = builders[kind](gross_m2, np.random.default_rng([layout_seed, attempt // 4]))
        free_m2 = float((~solid).sum()) * RESOLUTION_M**2
        if abs(free_m2 / area_m2 - 1.0) < best_error:
            best, best_error = solid, abs(free_m2 / area_m2 - 1.0)
        if best_error < _TOLERANCE:
            break
        gross_m2 *= area_m2 / free_m2
    assert best is not None
    return world_of(best, RESOLUTION_M)


def _connected(solid: Mask) -> Mask:
    """Fill what a body cannot get to: keep the largest space where it fits, and the cells next to that."""
    free = np.pad(~solid, 1)
    fits = ndimage.distance_transform_edt(free) * RESOLUTION_M > _BODY_M
    labels, _ = ndimage.label(fits)
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    room = labels == int(sizes.argmax())
    near = ndimage.distance_transform_edt(~room) * RESOLUTION_M <= _BODY_M + 2.0 * RESOLUTION_M
    parts, _ = ndimage.label(free & near)
    kept: Mask = (parts == parts[room][0])[1:-1, 1:-1]
    return ~kept


def _office(gross_m2: float, rng: np.random.Generator) -> Mask:
    """Units of room row, corridor, room row, stacked upwards and joined by cross corridors."""
    units = max(1, round(sqrt(gross_m2 / 1.5) / 12.5))
    height = min(max(sqrt(gross_m2 / 1.5), 6.0 * units), 13.5 * units)
    width = gross_m2 / height
    plan = FloorPlan(width, height, RESOLUTION_M, rng)
    corridor = float(rng.uniform(1.7, 2.3)) if gross_m2 > 80.0 else 1.4
    crossings = plan.crossings(corridor) if units > 1 else []
    for unit in range(units):
        bottom, top = unit * height / units, (unit + 1) * height / units
        middle = (bottom + top) / 2.0 + float(rng.uniform(-0.06, 0.06)) * (top - bottom)
        plan.carve(0.0, middle - corridor / 2.0, width, middle + corridor / 2.0)
        plan.room_row(crossings, bottom, middle - corridor / 2.0, door_at_top=True)
        plan.room_row(crossings, middle + corridor / 2.0, top, door_at_top=False)
    for low, high in crossings:
        plan.carve(low, height / units / 2.0, high, height - height / units / 2.0)
    plan.furnish()
    return _connected(plan.solid)


def _hall(gross_m2: float, rng: np.random.Generator) -> Mask:
    """One large hall: a grid of pillars, debris strewn between them."""
    aspect = float(rng.uniform(1.2, 1.8))
    width, height = sqrt(gross_m2 * aspect), sqrt(gross_m2 / aspect)
    shape = (round(height / RESOLUTION_M), round(width / RESOLUTION_M))
    solid = np.zeros(shape, dtype=bool)
    solid[[0, 1, -2, -1], :] = True
    solid[:, [0, 1, -2, -1]] = True
    x, y = np.meshgrid((np.arange(shape[1]) + 0.5) * RESOLUTION_M, (np.arange(shape[0]) + 0.5) * RESOLUTION_M)
    spacing, half = float(rng.uniform(4.5, 6.5)), float(rng.uniform(0.2, 0.35))
    for px in np.arange(spacing / 2.0, width - 1.0, spacing):
        for py in np.arange(spacing / 2.0, height - 1.0, spacing):
            solid |= (abs(x - px) < half) & (abs(y - py) < half)
    for _ in range(round(gross_m2 / 14.0)):
        px, py, turn = rng.uniform(0.0, width), rng.uniform(0.0, height), rng.uniform(0.0, pi)
        long, short = rng.uniform(0.2, 0.9), rng.uniform(0.15, 0.5)
        u = cos(turn) * (x - px) + sin(turn) * (y - py)
        v = -sin(turn) * (x - px) + cos(turn) * (y - py)
        if rng.random() < 0.5:
            solid |= (abs(u) < long) & (abs(v) < short)
        else:
            solid |= (u / long) ** 2 + (v / short) ** 2 < 1.0
    return _connected(solid)
