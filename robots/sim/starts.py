"""Where robots start and where victims lie."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robots.se2 import Array, wrap
from robots.sim.rays import cast, in_sight
from robots.sim.world import World, WorldError

StartKind = Literal["same", "spread"]
_SPACINGS_M = (1.0, 0.6)  # side by side with room to turn, or else as close as it gets
_MARGIN_M = 0.05


@dataclass(frozen=True, slots=True)
class Victim:
    """Somebody to be found, lying still. Low enough to block neither beams nor bodies."""

    victim_id: str
    x_m: float
    y_m: float


def place_robots(
    world: World, robots: int, radius_m: float, kind: StartKind, rng: np.random.Generator
) -> Array:
    """Return start poses, (n, 3), of a team: together ("same", all heading one way) or far apart ("spread").

    Raises:
        WorldError: the world has no room for so many.
    """
    rows, columns = np.nonzero(world.reachable(radius_m + _MARGIN_M))
    spots = _centres(world, rows, columns)
    if kind == "same":
        return _together(world, spots, robots, 2.0 * radius_m + 0.1, rng)
    candidates = spots[rng.permutation(len(spots))[:400]]
    places = _far_apart(candidates, robots)
    if len(places) < robots or _closest(places) < 2.0 * radius_m + 0.1:
        raise WorldError(f"the map has no room for {robots} robots; use fewer, or a larger map")
    return np.column_stack([places, rng.uniform(-pi, pi, robots)])


def place_victims(
    world: World, count: int, radius_m: float, robots_m: Array, rng: np.random.Generator
) -> tuple[Victim, ...]:
    """Return victims beside walls, at least 1.5 m apart and 3 m from the robots' starts, (n, 2).

    Where the world is too small for these distances they are relaxed.

    Raises:
        WorldError: even without them there is no place.
    """
    mask = world.reachable(radius_m) & (world.clearance_m <= radius_m + 0.35)
    spots = _centres(world, *np.nonzero(mask))
    spots = spots[rng.permutation(len(spots))]
    for apart_m, away_m in ((1.5, 3.0), (1.5, 1.5), (0.75, 0.75)):
        chosen: list[Array] = []
        for spot in spots:
            if len(chosen) == count:
                break
            if _away(robots_m, spot) >= away_m and _away(np.array(chosen).reshape(-1, 2), spot) >= apart_m:
                chosen.append(spot)
        if len(chosen) == count:
            return tuple(Victim(f"V{k + 1}", float(x), float(y)) for k, (x, y) in enumerate(chosen))
    raise WorldError(f"the map has no room for {count} victims; use fewer, or a larger map")


def place_tags(world: World, count: int, radius_m: float, rng: np.random.Generator) -> Array:
    """Return places for tags, (count, 2), as far from each other as they get where robots can go.

    Raises:
        WorldError: the world has no room for so many.
    """
    if count == 0:
        return np.zeros((0, 2))
    spots = _centres(world, *np.nonzero(world.reachable(radius_m)))
    if len(spots) < count:
        raise WorldError(f"the map has no room for {count} tags; use fewer, or a larger map")
    return _far_apart(spots[rng.permutation(len(spots))[: max(400, 10 * count)]], count)


def _together(world: World, spots: Array, robots: int, closest_m: float, rng: np.random.Generator) -> Array:
    """Pack the team round a random spot, nearest places first; all look where the view is longest."""
    for spacing_m in _SPACINGS_M:
        for _ in range(10):
            middle = spots[int(rng.integers(len(spots)))]
            places = _packed(world, spots, middle, robots, max(spacing_m, closest_m))
            if len(places) == robots:
                headings = np.arange(8, dtype=np.float64) * (pi / 4.0)
                views = cast(world, float(middle[0]), float(middle[1]), headings, 30.0)
                heading = wrap(float(headings[int(np.argmax(np.minimum(views, 30.0)))]))
                return np.column_stack([places, np.full(robots, heading)])
    raise WorldError(f"the map has no room for {robots} robots side by side; use fewer, or --start spread")


def _packed(world: World, spots: Array, middle: Array, robots: int, spacing_m: float) -> Array:
    """Choose places, (n, 2), in sight of the middle and not too far from it."""
    away = np.hypot(*(spots - middle).T)
    chosen: list[Array] = []
    for index in np.argsort(away, kind="stable"):
        spot = spots[index]
        if len(chosen) == robots or away[index] > 1.0 + spacing_m * robots:
            break
        apart = _away(np.array(chosen).reshape(-1, 2), spot) >= spacing_m
        if apart and in_sight(world, (float(middle[0]), float(middle[1])), (float(spot[0]), float(spot[1]))):
            chosen.append(spot)
    return np.array(chosen).reshape(-1, 2)


def _far_apart(candidates: Array, count: int) -> Array:
    """Choose points, (count, 2), each as far as possible from those before it."""
    chosen = [candidates[0]]
    gaps = np.hypot(*(candidates - candidates[0]).T)
    while len(chosen) < count:
        chosen.append(candidates[int(gaps.argmax())])
        gaps = np.minimum(gaps, np.hypot(*(candidates - chosen[-1]).T))
    return np.array(chosen)


def _closest(places: Array) -> float:
    gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    return float(gaps[np.triu_indices(len(places), 1)].min(initial=np.inf))


def _away(places: Array, spot: Array) -> float:
    return float(np.hypot(*(places - spot).T).min(initial=np.inf))


def _centres(world: World, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> Array:
    x = world.origin_m[0] + (columns + 0.5) * world.resolution_m
    y = world.origin_m[1] + (rows + 0.5) * world.resolution_m
    return np.column_stack([x, y])
