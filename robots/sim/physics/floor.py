"""What the wheels stand on: concrete with slippery patches, and slopes.

Friction coefficients of rubber are those of the usual tables: ice about 0.1, loose paper and cardboard 0.3 to
0.4, lino and wood 0.5 to 0.7, concrete 0.8 to 1.0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, tan

import numpy as np

from robots.se2 import Array

ARENA_M = 7.0  # side of the square, walled all round
GRAVITY_MPS2 = 9.81
_EDGE_M = 0.25  # a slope begins over so much


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """Discs on a floor of friction ``base``.

    ``patches`` (n, 4): x, y, radius (m), friction; later ones lie on top. ``slopes`` (m, 5): x, y, radius (m)
    and the slope's rise per metre along x and y. Coordinates from the middle of the arena.
    """

    base: float
    patches: Array
    slopes: Array

    def friction(self, points_m: Array) -> Array:
        """Return the friction coefficient under points (k, 2), as (k,)."""
        away = np.hypot(points_m[:, :1] - self.patches[:, 0], points_m[:, 1:] - self.patches[:, 1])
        above = (away < self.patches[:, 2]) * np.arange(1, len(self.patches) + 1)  # the topmost counts
        layers = np.concatenate([[self.base], self.patches[:, 3]])
        found: Array = layers[above.max(axis=1, initial=0)]
        return found

    def gravity(self, x_m: float, y_m: float) -> tuple[float, float, float]:
        """Return gravity in the floor's frame, where it points aside on a slope."""
        away = np.hypot(x_m - self.slopes[:, 0], y_m - self.slopes[:, 1])
        share = np.clip((self.slopes[:, 2] - away) / _EDGE_M, 0.0, 1.0)
        rise_x, rise_y = (float(rise) for rise in share @ self.slopes[:, 3:])
        down = GRAVITY_MPS2 / (1.0 + rise_x**2 + rise_y**2) ** 0.5
        return -down * rise_x, -down * rise_y, -down


def draw_floor(rng: np.random.Generator) -> Floor:
    """Return a floor of concrete or lino; about a quarter of it is slippery and an eighth slopes."""
    base = rng.uniform(0.8, 1.0) if rng.random() < 0.75 else rng.uniform(0.5, 0.7)
    patches = []
    for _ in range(int(rng.integers(12, 19))):
        friction = rng.uniform(0.08, 0.15) if rng.random() < 0.4 else rng.uniform(0.25, 0.4)
        patches.append([*_place(rng), rng.uniform(0.4, 0.9), friction])
    slopes = []
    for _ in range(int(rng.integers(2, 6))):
        steep, towards = tan(radians(rng.uniform(5.0, 16.0))), rng.uniform(-np.pi, np.pi)
        slopes.append([*_place(rng), rng.uniform(0.9, 1.5), steep * np.cos(towards), steep * np.sin(towards)])
    return Floor(float(base), np.array(patches), np.array(slopes))


def _place(rng: np.random.Generator) -> tuple[float, float]:
    x, y = rng.uniform(-ARENA_M / 2.0, ARENA_M / 2.0, 2)
    return float(x), float(y)
