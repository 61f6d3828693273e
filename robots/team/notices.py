"""What does not fit, in words an operator understands."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robots.estimation.tag_graph.trust import Judgement, TagVerdict
from robots.graph_report import GraphReport
from robots.team.problem import JointProblem
from robots.team.types import TeamNotice

_OFTEN = 3  # contradictions of one robot's way, from which it may be two robots,
_SHARE = 0.25  # where they are so many of its readings
_AWAY_SD = 8.0  # a reading so far off is not believed


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
    disbelieved = _disbelieved(joint, judged)
    notices = []
    for name in sorted({*edges, *disbelieved}):
        of_robot, begin = edges.get(name, []), joint.begins[name]
        pairs = joint.problem.edge_pairs[of_robot] - begin
        since, until = graphs[name].stamps_s[pairs[0]] if len(pairs) else (disbelieved[name], np.nan)
        if name in disbelieved or len(of_robot) >= _OFTEN:
            text = (
                f"The way of {name} contradicts the tags it read again and again since {clock(since)}: "
                "do two robots report as one?"
            )
        else:
            text = (
                f"The way of {name} between {clock(since)} and {clock(until)} contradicts the tags it read: "
                "it was carried, or slipped."
            )
        notices.append(TeamNotice("way", name, text, float(since), (name,)))
    return notices


def _disbelieved(joint: JointProblem, judged: Judgement) -> dict[str, float]:
    """Return robots whose readings of sound tags the solution let go of in numbers, and since when."""
    found = {}
    doubted = {verdict.tag for verdict in judged.verdicts}
    tags = judged.tag_of[judged.problem.sighting_pairs[:, 1]]
    sound = ~np.isin(tags, list(doubted))
    away = sound & (judged.solution.sighting_residuals > _AWAY_SD)
    for index, name in enumerate(joint.names):
        mine = joint.readers == index
        if away[mine].sum() >= max(_OFTEN, _SHARE * mine.sum()):
            found[name] = float(joint.stamps_s[mine & away].min())
    return found


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
