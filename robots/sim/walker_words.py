"""A phone's sentence as a person takes it: so many metres, then left, right or back, and so many again."""

from __future__ import annotations

import re
from dataclasses import dataclass

_PIECE = re.compile(r"(?:turn (left|right|round) and )?\bgo (?:about )?(\d+) m", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Piece:
    """So many metres along; ``turn``: left, right or round before that, None at the beginning."""

    metres: float
    turn: str | None = None


def pieces_of(text: str) -> list[Piece]:
    """Return the pieces of "Go 6 m north, turn left and go 3 m to tag A4.", in their order."""
    return [Piece(float(metres), turn.lower() or None) for turn, metres in _PIECE.findall(text)]
