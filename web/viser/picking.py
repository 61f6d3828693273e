"""What somebody means who clicks into the scene: the thing nearest to the ray through the pixel.

viser tells of clicks on single nodes as well, but seen from above a tag is two pixels wide: nobody hits that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from web.viser.places import Values, contains, of_kind, photo_places, place_of

_NEAREST_M = 0.05  # what is nearer to the eye, or behind it, is not meant


class Solid(NamedTuple):
    """How a kind of thing stands in the scene: an upright capsule over its place, in metres."""

    height_m: float
    radius_m: float


SOLIDS = {
    "robot": Solid(0.35, 0.45),
    "victim": Solid(2.2, 0.26),
    "tag": Solid(0.05, 0.16),
    "note": Solid(1.5, 0.2),
    "photo": Solid(1.2, 0.2),
}
ALERT_M = 1.8  # the pin of an alert, which stands for its tag
Named = tuple[str, str]  # kind and id


def pick(values: Values, origin_m: ArrayLike, direction: ArrayLike, reach_rad: float) -> Named | None:
    """Return kind and id of what a ray means, None for nothing.

    ``origin_m`` and ``direction`` (3,): the ray in the world frame; ``reach_rad``: how far beside a thing it
    may pass, as seen from the origin. Where it meets nothing that stands there, it means the smallest sector
    on the floor.
    """
    origin = np.asarray(origin_m, float)
    along = np.asarray(direction, float)
    length = float(np.linalg.norm(along))
    if not (np.isfinite(origin).all() and np.isfinite(along).all() and length > 0.0):
        return None
    along = along / length
    names, feet, solids = _standing(values)
    if names:
        beside, depth = _passes(feet, solids, origin, along)
        # which is nearest in the picture; of several that the ray goes through, the one nearest to the eye
        best = min(range(len(names)), key=lambda k: (beside[k], depth[k]))
        if beside[best] <= reach_rad:
            return names[best]
    return _sector(values, origin, along)


def _standing(values: Values) -> tuple[list[Named], NDArray[np.float64], NDArray[np.float64]]:
    """Return names, feet (n, 2) and solids (n, 2: height, radius) of all that stands in the scene."""
    found: list[tuple[Named, tuple[float, float], Solid]] = []
    alerting = {value.get("tag_id") for _, value in of_kind(values, "alert")}
    for key, value in values.items():
        board_kind, _, thing_id = key.partition("/")
        kind = "note" if board_kind == "annotation" else board_kind
        if kind not in ("robot", "victim", "tag", "note") or value.get("merged_into"):
            continue
        place = place_of(values, kind, thing_id)
        if place is not None:
            has_pin = kind == "tag" and thing_id in alerting
            solid = SOLIDS[kind]._replace(height_m=ALERT_M) if has_pin else SOLIDS[kind]
            found.append(((kind, thing_id), place, solid))
    found += [
        (("photo", photo_id), at, SOLIDS["photo"]) for photo_id, (at, _) in photo_places(values).items()
    ]
    feet = np.array([place for _, place, _ in found], float).reshape(-1, 2)
    return [name for name, _, _ in found], feet, np.array([s for _, _, s in found], float).reshape(-1, 2)


def _passes(
    feet: NDArray[np.float64],
    solids: NDArray[np.float64],
    origin: NDArray[np.float64],
    along: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how far the ray passes beside each capsule, as an angle (n,), and how far off that is (n,).

    The closest points of a ray o + t d and an axis w + s u, u = (0, 0, h), 0 <= s <= 1:
    s = (u.d d.w - u.w) / (u.u - (u.d)^2) and t = d.(w + s u), with w from o (Ericson, Real-Time Collision
    Detection, 5.1.9).
    """
    height, radius = solids.T
    w = np.column_stack((feet, np.zeros(len(feet)))) - origin
    ud = height * along[2]
    d_w, u_w = w @ along, height * w[:, 2]
    denominator = height**2 - ud**2
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.clip(np.where(denominator > 1e-12, (ud * d_w - u_w) / denominator, 0.0), 0.0, 1.0)
    axis = w + np.column_stack((np.zeros((len(feet), 2)), s * height))
    t = axis @ along
    distance = np.linalg.norm(axis - t[:, None] * along, axis=1)
    beside = np.arctan2(np.maximum(0.0, distance - radius), np.maximum(t, _NEAREST_M))
    return np.where(t > _NEAREST_M, beside, np.inf), t


def _sector(values: Values, origin: NDArray[np.float64], along: NDArray[np.float64]) -> Named | None:
    if along[2] * origin[2] >= 0.0:  # it never meets the floor
        return None
    x, y = (origin - along * origin[2] / along[2])[:2]
    inside = [
        (value["size_m2"], sector_id)
        for sector_id, value in of_kind(values, "sector")
        if contains(value["area_m"], float(x), float(y))
    ]
    return ("sector", min(inside)[1]) if inside else None
