"""Which robots of a recording are replayed, and in which order."""

from __future__ import annotations

from collections.abc import Sequence

from robots.datasets.recording import RecordingError


def choose_robots(there: Sequence[str], robots: str | None, order: str | None) -> tuple[str, ...]:
    """Return the robots to replay, in the order in which they go through the recording.

    Args:
        there: all robots, in the recording's order.
        robots: how many of the first ("3"), or names ("r1,r3"); None for all.
        order: names, first to last; the robots that it leaves out follow in the recording's order.

    Raises:
        RecordingError: a name is unknown or given twice, or there are not so many robots.
    """
    chosen = tuple(there)
    if robots is not None and robots.strip().isdecimal() and robots.strip() not in there:
        digits = robots.strip().lstrip("0")
        if not digits or len(digits) > len(str(len(there))) or int(digits) > len(there):
            raise RecordingError(f"--robots {robots}: the recording has {len(there)}: {', '.join(there)}")
        chosen = chosen[: int(digits)]
    elif robots is not None:
        wanted = _parsed("--robots", robots, there)
        chosen = tuple(robot_id for robot_id in there if robot_id in wanted)
    if order is not None:
        first = _parsed("--order", order, chosen)
        chosen = (*first, *(robot_id for robot_id in chosen if robot_id not in first))
    return chosen


def _parsed(option: str, text: str, there: Sequence[str]) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in there:
            raise RecordingError(f"{option}: there is no robot {name!r}; there are {', '.join(there)}")
        if names.count(name) > 1:
            raise RecordingError(f"{option} names {name} twice")
    return names
