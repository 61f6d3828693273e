"""From which tag to which people walked: they touched one after the other."""

from __future__ import annotations

from typing import Any

from server.board import Board

_MOST = 5000  # pairs of tags


class Walks:
    """Puts walks on the board as ``walk/ONE~OTHER``: of each pair of tags the shortest, either way."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._count = 0

    def take(self, body: dict[str, Any]) -> None:
        """Take what a phone said of a tag it read: ``from_tag``, ``after_s``, ``steps_m`` tell of a walk."""
        before = body.get("from_tag")
        if before is None or before == body["tag_id"]:
            return
        one, other = sorted((before, body["tag_id"]))
        key = f"walk/{one}~{other}"
        known = self._board.get(key)
        if known is None:
            if self._count >= _MOST:
                return
            self._count += 1
            known = {"steps_m": None, "after_s": 0.0}
        steps_m = [far for far in (known["steps_m"], body.get("steps_m")) if far is not None]
        walk = {
            "from_tag": one,
            "to_tag": other,
            "steps_m": min(steps_m, default=None),
            "after_s": max(known["after_s"], body["after_s"]),  # one walk that can be is enough
        }
        self._board.publish({key: walk})
