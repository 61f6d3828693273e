"""Choices that a scenario makes for each robot: pairs of a robot's name, or ``OTHERS``, and what it is."""

from __future__ import annotations

from collections.abc import Collection, Sequence

OTHERS = "*"  # in place of a robot's name: all that are not named
Pairs = tuple[tuple[str, str], ...]


class ScenarioError(ValueError):
    """A scenario cannot be played; the message names the field and what to do."""


def parse_pairs(option: str, text: str) -> Pairs:
    """Return the pairs of ``r1=ekf,r2=rslam,tag-graph``: one without a name is for all others, as is ``*``.

    Raises:
        ScenarioError: a robot, or the rest, is named twice, or something is missing.
    """
    pairs = []
    for part in text.split(","):
        name, equals, choice = part.strip().rpartition("=")
        if not choice or (equals and not name):
            raise ScenarioError(
                f"{option} {text!r}: give a name, or ROBOT=NAME for some, as in r1=NAME,OTHER"
            )
        pairs.append((name or OTHERS, choice))
    if len(dict(pairs)) < len(pairs):
        raise ScenarioError(f"{option} {text!r} names a robot, or the rest of them, twice")
    return tuple(pairs)


def check_pairs(option: str, pairs: Pairs, known: Collection[str], robot_ids: Sequence[str]) -> None:
    """Refuse a choice or a robot that does not exist. Raises ScenarioError."""
    for robot_id, choice in pairs:
        if choice not in known:
            raise ScenarioError(f"{option}: {choice!r} is unknown; use one of {', '.join(known)}")
        if robot_id not in (OTHERS, *robot_ids):
            raise ScenarioError(f"{option}: there is no robot {robot_id}; robots are r1 to r{len(robot_ids)}")


def chosen_for(pairs: Pairs, robot_id: str, usual: str) -> str:
    """Return what is chosen for a robot."""
    choices = dict(pairs)
    return choices.get(robot_id, choices.get(OTHERS, usual))
