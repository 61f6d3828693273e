"""Where somebody is who hears nodes, in words that need no map. The phone's fix_words.js says the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, sqrt

import numpy as np

from robots.estimation.radio.locating import Located
from robots.estimation.radio.places import Place
from robots.routes.texts import Language, say
from robots.routes.words import OF_PLAN, North, metres

_THERE_M = 1.0  # so near a tag is said to be here

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class NearTag:
    """The tag next to a place, and how one gets from it to the place."""

    tag_id: str
    distance_m: float
    bearing_deg: float


def right_to_m(place: Place) -> float:
    """Return how far off a place may be: two standard deviations along its longest axis."""
    middle, half = (place.var_x + place.var_y) / 2.0, (place.var_x - place.var_y) / 2.0
    return 2.0 * sqrt(max(0.0, middle + hypot(half, place.var_xy)))


def near_tag(place: Place, tags: Mapping[str, Point], north: North = OF_PLAN) -> NearTag:
    """Return the tag next to a place; of equals the first by name."""
    here = (place.x_m, place.y_m)
    far, tag_id = min((hypot(x - here[0], y - here[1]), tag) for tag, (x, y) in tags.items())
    return NearTag(tag_id, far, north.bearing_deg(np.array(tags[tag_id]), np.array(here)))


def fix_text(
    found: Located,
    tags: Mapping[str, Point],
    unknown: Sequence[str],
    language: Language = "en",
    north: North = OF_PLAN,
) -> str:
    """Return where one is, how well that is known, and what would tell more."""
    words = []
    if found.ring is not None:
        far, doubt = metres(found.ring.range_m), metres(2.0 * found.ring.sd_m)
        words.append(say(language, "fix_ring", far=far, tag=found.ring.node_id, doubt=doubt))
    for k, place in enumerate(found.places[:2]):
        near, doubt = near_tag(place, tags, north), metres(right_to_m(place))
        key = f"fix_{'or_' if k else ''}{'at' if near.distance_m < _THERE_M else 'near'}"
        way = north.point(near.bearing_deg, language)
        words.append(say(language, key, far=metres(near.distance_m), way=way, tag=near.tag_id, doubt=doubt))
    if len(found.places) > 1:
        words.append(say(language, "fix_walk"))
    if not found.fits:
        words.append(say(language, "fix_misfit"))
    if found.left_out is not None:
        words.append(say(language, "fix_left_out", tag=found.left_out))
    words += [say(language, "fix_unknown", tag=tag) for tag in unknown[:3]]
    return " ".join(words)
