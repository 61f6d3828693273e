"""The names of all methods: how to explore, how to agree with others, and who hears whom."""

from __future__ import annotations

from collections.abc import Collection

from robots.exploration.coordination import COORDINATIONS
from robots.exploration.strategies import STRATEGIES
from robots.exploration.team.communication import COMMUNICATIONS

KNOWN: dict[str, Collection[str]] = {
    "explore": STRATEGIES,
    "coordinate": COORDINATIONS,
    "communication": COMMUNICATIONS,
}


def unknown_method(name: str, value: str) -> str | None:
    """Return what is wrong with a method's name, with the known ones; None where it is known."""
    if value in KNOWN[name]:
        return None
    return f"{name}: there is no {value!r}; known are {', '.join(sorted(KNOWN[name]))}"


def hears_nobody(coordinate: str, communication: str) -> str:
    """Return in words that a robot which hears nobody shares out nothing; nothing where it does."""
    if communication in ("full", "radio") or coordinate in ("none", "node-counting"):
        return ""
    return (
        f"{coordinate} shares out nothing among robots that hear nobody: by {communication} they do not;"
        " choose full or radio"
    )
