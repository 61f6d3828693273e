"""Kleiner 2006 section V, corrected: to frontiers that others left open, away from where robots have been.

    U(f) = k(f) - alpha C(f) - beta sum over v in V, |f - v| < tau, of 1 / max(|f - v|, 0.4 m)

As printed, eq. (7) takes the distance itself for its reciprocal, so that frontiers far from visited places
are worth less; it divides by the age of a visit, so that a robot's own last seconds outweigh all that others
left; and it grows with the number of visits. Here a place of 0.4 m counts once, whoever went there, whenever.

Algorithm 2 by its text: a frontier of another robot is dropped when this robot's own map knows all round it,
not already when it has never been there; and one that lies in the unknown is planned to as if the way were
free. ``kleiner_printed`` is the paper to the letter.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, hypot

import numpy as np

from robots.exploration.frontiers import Frontier
from robots.exploration.strategy import ExplorationView, ways_of
from robots.planning.plan_grid import UNKNOWN, PlanGrid
from robots.se2 import Array
from robots.tags.memory import VISITED_M

NEAREST_M = VISITED_M


@dataclass(frozen=True, slots=True)
class Foreign(Frontier):
    """A frontier a tag tells of, at ``at_m`` (x, y); the goal is where the way to it leaves known ground."""

    at_m: tuple[float, float] = (0.0, 0.0)


class Kleiner:
    """Weighs frontiers of others and its own by the way and by the visits round them."""

    def candidates(self, view: ExplorationView) -> tuple[Frontier, ...]:
        """Return the robot's own frontiers and those others left open in ground that it does not know."""
        return view.frontiers + foreign_frontiers(view)

    def worths(self, view: ExplorationView) -> Array:
        """Return U(f), (n,), in metres of way."""
        told = view.settings.kleiner
        places = places_of_frontiers(view)
        k = is_foreign(view, told_frontiers(view))  # (8)
        crowd = crowding(places, visited_places(view), told.tau_m)
        worths: Array = (k - told.beta * crowd) / told.alpha - ways_of(view)  # (6), (7) corrected
        return worths

    def reason(self, view: ExplorationView, index: int) -> str:
        """Return whose frontier it is, and how much was driven near it."""
        crowd = crowding(places_of_frontiers(view), visited_places(view), view.settings.kleiner.tau_m)[index]
        whose = "the unknown that another robot left open" if _told(view, index) else "an edge of the unknown"
        return f"{whose}; {'nobody was near it' if crowd == 0.0 else 'robots have been near it'}"


def _told(view: ExplorationView, index: int) -> bool:
    return bool(is_foreign(view, told_frontiers(view))[index])


def told_frontiers(view: ExplorationView) -> Array:
    """Return F_o: where tags tell of open frontiers within tau of them, (m, 2) in the map frame."""
    tau_m = view.settings.kleiner.tau_m
    found = []
    for tag in view.tags:
        shifts = tag.memory.frontiers_m
        near = shifts[np.hypot(shifts[:, 0], shifts[:, 1]) < tau_m]
        found.append(near + np.array(tag.place_m))
    return np.concatenate([np.zeros((0, 2)), *found])


def visited_places(view: ExplorationView) -> Array:
    """Return V: places of 0.4 m where this robot was or tags tell of others, (m, 2), each once."""
    parts = [view.trail[:, :2]] + [tag.memory.visited_m + np.array(tag.place_m) for tag in view.tags]
    cells = np.rint(np.concatenate(parts) / VISITED_M)
    return np.unique(cells, axis=0) * VISITED_M


def crowding(places: Array, visited: Array, tau_m: float) -> Array:
    """Return the sum of 1 / max(d, 0.4) over visited places nearer than tau, (n,), of places (n, 2)."""
    if len(visited) == 0:
        return np.zeros(len(places))
    apart = np.hypot(*(places[:, None] - visited[None]).transpose(2, 0, 1))
    total: Array = np.where(apart < tau_m, 1.0 / np.maximum(apart, NEAREST_M), 0.0).sum(axis=1)
    return total


def places_of_frontiers(view: ExplorationView) -> Array:
    """Return where frontiers are, (n, 2); of one that a tag tells of, where it says so."""
    return np.array([f.at_m if isinstance(f, Foreign) else f.goal_m for f in view.frontiers]).reshape(-1, 2)


def is_foreign(view: ExplorationView, told: Array) -> Array:
    """Return k(f) of eq. (8), (n,): 1 of frontiers told of, (m, 2), and of its own in the same cell."""
    if len(told) == 0:
        return np.zeros(len(view.frontiers))
    apart = np.abs(places_of_frontiers(view)[:, None] - told[None]).max(axis=2)
    k: Array = (apart <= view.settings.tag_cell_m / 2.0).any(axis=1).astype(np.float64)
    return k


def foreign_frontiers(view: ExplorationView) -> tuple[Frontier, ...]:
    """Return frontiers that tags tell of and this robot's map does not know all round, with optimistic ways.

    The way leads to whichever of the robot's own frontiers is on it, and from there straight on.
    """
    grid = view.grid
    if grid is None or not view.frontiers:
        return ()
    found, cell_m = [], view.settings.tag_cell_m
    for x, y in np.unique(np.rint(told_frontiers(view) / cell_m), axis=0) * cell_m:
        if knows_all_round(grid, float(x), float(y), cell_m):
            continue
        ways = [f.cost_m + hypot(f.goal_m[0] - x, f.goal_m[1] - y) for f in view.frontiers]
        by = int(np.argmin(ways))
        own = view.frontiers[by]
        found.append(Foreign(own.goal, own.goal_m, cell_m, ways[by], (float(x), float(y))))
    return tuple(found)


def knows_all_round(grid: PlanGrid, x: float, y: float, cell_m: float = 1.0) -> bool:
    """Say whether the map knows every cell of the square of such a side round a point."""
    low, left = grid.cell_of(x - cell_m / 2.0, y - cell_m / 2.0)
    high, right = (start + floor(cell_m / grid.cell_m) for start in (low, left))
    rows, columns = grid.cells.shape
    if low < 0 or left < 0 or high > rows or right > columns:
        return False
    return bool((grid.cells[low:high, left:right] != UNKNOWN).all())
