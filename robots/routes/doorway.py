"""Whether a place lies in a doorway: narrow, soon over, and what it joins is parted by it."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from robots.routes.outlook import ANGLES, RAYS, UNKNOWN, WALL, Outlook, Plan, outlook
from robots.se2 import Array

_DOORWAY_M, _THROUGH_M = 1.4, 1.0  # no wider, and over within so much on either side
_WIDER = 1.6  # is what opens there
_ABOUT_M = 2.8  # no other way round is looked for farther off
_OPPOSITE = RAYS // 2  # rays from one to the other
_ASIDE = RAYS // 12  # fewer between jambs for whom stands a step before or behind their line


def is_doorway(plan: Plan, place_m: Array, here: Outlook) -> bool:
    """Say whether a place (2,) of the world frame lies in a doorway; ``here`` is what is seen from it."""
    wide_m, jambs_m = _narrowest(here, _ASIDE)
    if not 0.0 < wide_m <= _DOORWAY_M:
        return False
    middle_m, along = place_m + jambs_m.mean(axis=0), (jambs_m[1] - jambs_m[0]) / wide_m
    through_m = _THROUGH_M * np.array([-along[1], along[0]])
    for side_m in (through_m, -through_m):
        beyond = outlook(plan, middle_m + side_m)
        ray = round(float(np.arctan2(*-side_m[::-1])) / ANGLES[1]) % RAYS
        if beyond.ranges_m[ray] <= _THROUGH_M or _narrowest(beyond, 0)[0] < _WIDER * wide_m:
            return False
    cells = _about(plan, middle_m)
    middle = len(cells) // 2
    rows, columns = np.mgrid[-middle : middle + 1, -middle : middle + 1]
    near_m = plan.resolution_m * np.stack([columns, rows], axis=-1)
    on_line = (abs(near_m @ through_m) <= _THROUGH_M * plan.resolution_m) & (abs(near_m @ along) <= wide_m)
    parts, _ = ndimage.label((cells != WALL) & ~on_line)
    out = np.round(through_m[::-1] / plan.resolution_m).astype(int)
    return bool(parts[tuple(middle + out)] != parts[tuple(middle - out)])


def _narrowest(seen: Outlook, aside: int) -> tuple[float, Array]:
    """Return how near walls on opposite sides of a place, or up to so many rays less, come to each other.

    And where they do (2, 2), from the place.
    """
    spans = np.arange(_OPPOSITE - aside, _OPPOSITE + 1)
    first = np.repeat(np.arange(RAYS), len(spans))
    second = (first + np.tile(spans, RAYS)) % RAYS
    corners_m = seen.corners_m
    apart_m = np.hypot(*(corners_m[second] - corners_m[first]).T)
    apart_m[(seen.ends[first] != WALL) | (seen.ends[second] != WALL)] = np.inf
    k = int(apart_m.argmin())
    return float(apart_m[k]), corners_m[[first[k], second[k]]]


def _about(plan: Plan, place_m: Array) -> Array:
    """Return the cells (2 k + 1, 2 k + 1) about a place; beyond the map they are unknown."""
    reach = round(_ABOUT_M / plan.resolution_m)
    column, row = np.floor((place_m - plan.origin_m) / plan.resolution_m).astype(int)
    rows, columns = row + np.arange(-reach, reach + 1), column + np.arange(-reach, reach + 1)
    height, width = plan.cells.shape
    inside = ((rows >= 0) & (rows < height))[:, None] & (columns >= 0) & (columns < width)
    cells = plan.cells[rows.clip(0, height - 1)[:, None], columns.clip(0, width - 1)]
    return np.where(inside, cells, UNKNOWN)
