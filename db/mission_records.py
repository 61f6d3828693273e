"""What the store hands out of how missions go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class EndingRecord:
    """What is left of a mission that was closed: its board, and its map as an encoded ``TeamGrid``."""

    ended_unix_s: float
    board: dict[str, dict[str, Any]]
    grid: bytes | None


@dataclass(frozen=True, slots=True)
class ProgressRecord:
    """How far a mission was at a moment; ``clock_s`` is its robots' own."""

    unix_s: float
    clock_s: float
    explored_m2: float
    tags: int
    victims: int
