"""A mission's changes as text, put together once for all who keep up with them.

Who is still taking in the last text holds the keys that changed meanwhile, and gets their latest values in
one text of its own: never a backlog.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from server.board import Board, Subscription

PAUSE_S = 0.02  # changes are told at most this often
HEARTBEAT_S = 1.0


class Broadcast:
    """Tells all listeners of a board's changes at the same moments. For one event loop."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._listeners: set[Listener] = set()
        self._telling: asyncio.Task[None] | None = None

    @contextmanager
    def listener(self) -> Iterator[Listener]:
        """Listen to all changes from this moment on, until left; nothing runs while nobody does."""
        listener = Listener(self)
        self._listeners.add(listener)
        if self._telling is None:
            subscription = self._board.subscribe()  # now: the task begins later
            self._telling = asyncio.create_task(self._tell(subscription), name="broadcast")
            self._telling.add_done_callback(lambda _: subscription.close())
        try:
            yield listener
        finally:
            self._listeners.discard(listener)
            if not self._listeners:
                self._telling.cancel()
                self._telling = None

    def snapshot_text(self) -> str:
        """Return the message that everything begins with."""
        text = '{"type":"snapshot","server_unix_s":%.3f,"state":%s}'
        return text % (time.time(), self._board.snapshot_text())

    def changes_text(self, keys: Iterable[str]) -> str:
        """Return the message about keys that changed; without any it is a heartbeat."""
        there, gone = self._board.changes_text(keys)
        text = '{"type":"changes","server_unix_s":%.3f,"set":%s,"delete":%s}'
        return text % (time.time(), there, gone)

    async def _tell(self, subscription: Subscription) -> None:
        while True:
            keys = await subscription.next_keys(HEARTBEAT_S)
            text = self.changes_text(keys)
            for listener in self._listeners:
                listener.note(keys, text)
            await asyncio.sleep(PAUSE_S)


class Listener:
    """What one listener has not taken yet: the text that all get, or the keys of several."""

    def __init__(self, broadcast: Broadcast) -> None:
        self._broadcast = broadcast
        self._keys: dict[str, None] = {}  # a set that keeps its order
        self._text: str | None = None
        self._woken = asyncio.Event()

    def note(self, keys: Iterable[str], text: str) -> None:
        """Take note of keys that changed, and of the text about them."""
        self._text = None if self._woken.is_set() else text
        self._keys.update(dict.fromkeys(keys))
        self._woken.set()

    async def next_text(self) -> str:
        """Wait for the next message and return it."""
        await self._woken.wait()
        self._woken.clear()
        text, keys = self._text, self._keys
        self._text, self._keys = None, {}
        return self._broadcast.changes_text(keys) if text is None else text
