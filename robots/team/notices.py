"""What does not fit, in words an operator understands."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robots.estimation.tag_trust import Judgement, TagVerdict
from robots.team.problem import JointProblem
from robots.team.types import TeamNotice
from robots.types import GraphReport

_OFTEN = 3  # contradictions of one robot's way, from which it may be two robots


def tag_notices(joint: JointProblem, judged: Judgement) -> dict[int, TeamNotice]:
    """Return a notice for each tag that is not what its sightings claim, by its index."""
    return {verdict.tag: _tag_notice(joint, verdict) for verdict in judged.verdicts}


def way_notices(
    joint: JointProblem, judged: Judgement, graphs: Mapping[str, GraphReport]
) -> list[TeamNotice]:
    """Return one notice for each robot whose way contradicts the tags it read."""
    edges: dict[str, list[int]] = {}
    for edge in judged.loosened:
        driver = joint.drivers[np.flatnonzero(joint.ways == edge)[0]]
        edges.setdefault(joint.names[int(driver)], []).append(edge)
    notices = []
    for name, of_robot in sorted(edges.items()):
        graph, begin = graphs[name], joint.begins[name]
        pair = joint.problem.edge_pairs[of_robot[0]] - begin
        since, until = (float(stamp) for stamp in graph.stamps_s[pair])
        if len(of_robot) < _OFTEN:
            text = (
                f"The way of {name} between {clock(since)} and {clock(until)} contradicts the tags it read: "
                "it was carried, or slipped."
            )
        else:
            text = (
                f"The way of {name} contradicts the tags it read {len(of_robot)} times since {clock(since)}: "
                "do two robots report as one?"
            )
        notices.append(TeamNotice("way", name, text, since, (name,)))
    return notices


def clock(stamp_s: float) -> str:
    """Return a mission time as minutes and seconds."""
    minutes, seconds = divmod(round(max(stamp_s, 0.0)), 60)
    return f"{minutes}:{seconds:02d}"


def _tag_notice(joint: JointProblem, verdict: TagVerdict) -> TeamNotice:
    tag = joint.tag_ids[verdict.tag]
    of_tag = joint.problem.sighting_pairs[:, 1] == verdict.tag
    robots = tuple(sorted({joint.names[int(k)] for k in joint.readers[of_tag]}))
    if verdict.state == "wrong":
        first = verdict.strays[0]
        who, when = joint.names[int(joint.readers[first])], float(joint.stamps_s[first])
        text = f"{who} read {tag} at {clock(when)} where it cannot be; that reading is left out."
        return TeamNotice("doubtful", tag, text, when, robots)
    if verdict.state == "moved":
        since = float(verdict.firsts_s[-1])
        shift = float(np.hypot(*(verdict.places_m[-1] - verdict.places_m[-2])))
        between = f"between {clock(float(verdict.lasts_s[-2]))} and {clock(since)}"
        text = f"Tag {tag} was moved by {shift:.1f} m {between}; it is shown where it was read last."
        return TeamNotice("moved", tag, text, since, robots)
    count = len(verdict.places_m)
    since = float(np.sort(verdict.firsts_s)[1])
    return TeamNotice(
        "cloned",
        tag,
        f"{count} tags answer to {tag}, the second read first at {clock(since)}.",
        since,
        robots,
    )
