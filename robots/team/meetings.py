"""Robots that saw one another: which pose vertex saw whom, and where the other was by its own account."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robots.se2 import Array
from robots.team.history import History, Whereabouts
from robots.types import GraphReport

_APART_S = 2.0  # sightings of a robot by another nearer in time than this are one: their errors are shared


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A robot seen by another: ``offset_m`` (2,) of its base in the frame of pose vertex ``pose``.

    ``covariance`` (2, 2); ``there``: where ``seen`` was by its own account.
    """

    seer: str
    pose: int
    seen: str
    stamp_s: float
    offset_m: Array
    covariance: Array
    there: Whereabouts


def meetings_of(graphs: Mapping[str, GraphReport], histories: Mapping[str, History]) -> tuple[Meeting, ...]:
    """Return the meetings of robots that are both known, thinned, in the order of names and time."""
    found = []
    for seer, graph in sorted(graphs.items()):
        latest: dict[str, float] = {}
        for k in np.argsort(graph.meeting_stamps_s, kind="stable"):
            seen, stamp_s = graph.meeting_robots[k], float(graph.meeting_stamps_s[k])
            pose = int(graph.meeting_poses[k])
            if seen == seer or seen not in graphs or not 0 <= pose < len(graph.poses):
                continue
            if stamp_s < latest.get(seen, -np.inf) + _APART_S or not _is_sound(graph, int(k)):
                continue
            there = histories[seen].at(stamp_s)
            if there is None or not 0 <= there.anchor < len(graphs[seen].poses):
                continue
            latest[seen] = stamp_s
            found.append(
                Meeting(
                    seer, pose, seen, stamp_s, graph.meeting_offsets[k], graph.meeting_covariances[k], there
                )
            )
    return tuple(found)


def _is_sound(graph: GraphReport, k: int) -> bool:
    covariance = graph.meeting_covariances[k]
    if not np.isfinite(graph.meeting_offsets[k]).all() or not np.isfinite(covariance).all():
        return False
    return bool(np.linalg.eigvalsh((covariance + covariance.T) / 2.0)[0] > 0.0)
