"""Of what kind the places of tags are; worked out again only where the map about one has changed."""

from __future__ import annotations

import hashlib

import numpy as np

from robots.routes.place_kind import PlaceKind, around, kind_of
from robots.routes.sight import OCCUPIED_FROM
from robots.team import TeamGrid

_SURE_M = 1.0  # a tag whose place is known no better may lie on the other side of a wall


class PlaceKinds:
    """Answers for one mission, from any thread."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[bytes, PlaceKind]] = {}  # by tag: of what, and the answer

    def of(self, grid: TeamGrid | None, tag_id: str, place_m: tuple[float, float], sd_m: float) -> PlaceKind:
        """Return of what kind a tag's place in the world frame is, "" where nothing tells."""
        if grid is None or sd_m > _SURE_M:
            return ""
        near = around(grid, *place_m)
        seen = hashlib.blake2b(repr((place_m, near.origin_m, near.cells.shape)).encode(), digest_size=16)
        for mask in (near.cells >= OCCUPIED_FROM, near.cells < 0):
            seen.update(np.packbits(mask).tobytes())
        known = self._known.get(tag_id)
        if known is None or known[0] != seen.digest():
            known = self._known[tag_id] = seen.digest(), kind_of(grid, *place_m)
        return known[1]
