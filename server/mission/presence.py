"""Who is watching a mission just now."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from server.board import Board
from server.people.actor import Actor


class Presence:
    """People with a page of the mission open, on the board as ``person/NAME``."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._pages: Counter[str] = Counter()
        self._since: dict[str, float] = {}

    @contextmanager
    def of(self, actor: Actor) -> Iterator[None]:
        """Show a person as long as the page is open; robots and programs are not shown."""
        if actor.is_robot:
            yield
            return
        self._count(actor, 1)
        try:
            yield
        finally:
            self._count(actor, -1)

    def _count(self, actor: Actor, more: int) -> None:
        name = actor.name
        self._pages[name] += more
        if self._pages[name] == 0:
            del self._pages[name], self._since[name]
            self._board.publish({f"person/{name}": None})
            return
        since = self._since.setdefault(name, time.time())
        value = {"name": name, "role": actor.role, "since_unix_s": since, "pages": self._pages[name]}
        self._board.publish({f"person/{name}": value})
