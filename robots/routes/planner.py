"""The best route over ways that were driven: Dijkstra 1959 over tags."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from robots.routes.hazards import Hazard, is_near
from robots.routes.ways import Way, centimetres, shortest_ways
from robots.se2 import Array

_HAZARD_COST_CM = 5000  # so long a detour is better than passing a hazard


class NoRouteError(ValueError):
    """There is no such route; the message says why and what to do."""


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """One way of a route; ``hazards`` it passes, ``sd_m`` how well its ends are known to each other."""

    way: Way
    hazards: tuple[str, ...] = ()
    sd_m: float = 0.0


class RouteMap:
    """Tags and the ways between them. ``sds_m``: how well each tag's place is known.

    Costs are whole centimetres: a phone that adds them in another order finds the same route.
    """

    def __init__(
        self, ways: Iterable[Way], sds_m: Mapping[str, float] | None = None, hazards: Sequence[Hazard] = ()
    ) -> None:
        self._ways = shortest_ways(ways)
        self._sds_m = sds_m or {}
        self._all_hazards = tuple(hazards)
        self._next: dict[str, list[tuple[str, int]]] = defaultdict(list)
        self._hazards: dict[tuple[str, str], tuple[str, ...]] = {}
        for key, way in self._ways.items():
            self._hazards[key] = found = self.hazards_near(way.points_m)
            self._next[key[0]].append((key[1], way.cost_cm + _HAZARD_COST_CM * len(found)))

    @property
    def tags(self) -> frozenset[str]:
        """The tags that a way leads to."""
        return frozenset(self._next)

    @property
    def ways(self) -> list[Way]:
        """The ways, one for each pair of tags that are next to each other."""
        return [way for (a, b), way in self._ways.items() if a < b]

    def hazards_near(self, points_m: Array) -> tuple[str, ...]:
        """Return what a line of points (n, 2) passes."""
        return tuple(hazard.text for hazard in self._all_hazards if is_near(points_m, hazard))

    def neighbours(self, tag_id: str) -> list[Way]:
        """Return the ways from a tag to those next to it, the shortest first."""
        ways = [self._ways[tag_id, other] for other, _ in self._next.get(tag_id, ())]
        return sorted(ways, key=lambda way: (centimetres(way.length_m), way.to_tag))

    def route(
        self, from_tag: str, to_tags: Iterable[str], ends_m: Mapping[str, float] | None = None
    ) -> list[Leg]:
        """Return the best route to one of some tags; ``ends_m`` is what is still to go from each of them.

        Raises:
            NoRouteError: no robot has driven from there to any of them.
        """
        ends = {tag: 0 if ends_m is None else centimetres(ends_m[tag]) for tag in to_tags}
        costs, before = {from_tag: 0}, dict[str, str]()
        done: set[str] = set()
        best: tuple[int, str] | None = None
        queue = [(0, from_tag)]
        while queue:
            cost, tag = heapq.heappop(queue)
            if best is not None and cost > best[0]:
                break
            if tag in done:
                continue
            done.add(tag)
            if tag in ends and (best is None or (cost + ends[tag], tag) < best):
                best = cost + ends[tag], tag
            for other, step in self._next.get(tag, ()):
                total = cost + step
                if other not in costs or total < costs[other]:
                    costs[other], before[other] = total, tag
                    heapq.heappush(queue, (total, other))
        if best is None:
            raise NoRouteError(f"no robot has driven from tag {from_tag} to there yet; read another tag")
        tags = [best[1]]
        while tags[-1] != from_tag:
            tags.append(before[tags[-1]])
        tags.reverse()
        return [self._leg(a, b) for a, b in pairwise(tags)]

    def _leg(self, a: str, b: str) -> Leg:
        sd_m = float(np.hypot(self._sds_m.get(a, 0.0), self._sds_m.get(b, 0.0)))
        return Leg(self._ways[a, b], self._hazards[a, b], sd_m)
