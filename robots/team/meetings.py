"""Robots that saw one another: which pose vertex saw whom, and where the other was by its own account."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robots.graph_report import GraphReport
from robots.se2 import Array
from robots.team.history import History, Whereabouts

# Sightings of a robot by another nearer in time than this are one, since they share their errors. A batch
# solve of ranges finds out for how long they do.
_APART_S, _APART_RANGED_S = 2.0, 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A robot seen by another: ``offset_m`` (2,) of its base in the frame of pose vertex ``pose``.

    ``covariance`` (2, 2); ``base`` (3,): where the seer was in that frame; ``there``: where ``seen`` was by
    its own account.
    """

    seer: str
    pose: int
    seen: str
    stamp_s: float
    offset_m: Array
    covariance: Array
    base: Array
    there: Whereabouts


def meetings_of(graphs: Mapping[str, GraphReport], histories: Mapping[str, History]) -> tuple[Meeting, ...]:
    """Return the meetings of robots that are both known, thinned, in the order of names and time."""
    ranged = any(len(graph.range_pairs) for graph in graphs.values())
    apart_s = _APART_RANGED_S if ranged else _APART_S
    found = []
    for seer, graph in sorted(graphs.items()):
        told = len(graph.meeting_bases) == len(graph.meeting_poses)
        bases = graph.meeting_bases if told else np.zeros((len(graph.meeting_poses), 3))
        latest: dict[str, float] = {}
        for k in np.argsort(graph.meeting_stamps_s, kind="stable"):
            seen, stamp_s = graph.meeting_robots[k], float(graph.meeting_stamps_s[k])
            pose = int(graph.meeting_poses[k])
            if seen == seer or seen not in graphs or not 0 <= pose < len(graph.poses):
                continue
            if stamp_s < latest.get(seen, -np.inf) + apart_s or not _is_sound(graph, int(k)):
                continue
            there = histories[seen].at(stamp_s)
            if there is None or not 0 <= there.anchor < len(graphs[seen].poses):
                continue
            latest[seen] = stamp_s
            found.append(
                Meeting(
                    seer,
                    pose,
                    seen,
                    stamp_s,
                    graph.meeting_offsets[k],
                    graph.meeting_covariances[k],
                    bases[k],
                    there,
                )
            )
    return tuple(found)


def _is_sound(graph: GraphReport, k: int) -> bool:
    covariance = graph.meeting_covariances[k]
    if not np.isfinite(graph.meeting_offsets[k]).all() or not np.isfinite(covariance).all():
        return False
    if len(graph.meeting_bases) > k and not np.isfinite(graph.meeting_bases[k]).all():
        return False
    return bool(np.linalg.eigvalsh((covariance + covariance.T) / 2.0)[0] > 0.0)
