"""What everybody sees of a mission: keyed state where the latest value wins, and who is told of its changes.

A subscriber holds the keys that changed since it last looked, not the changes: one that is slow gets fewer
and newer updates, never a backlog.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

Value = dict[str, Any]


class Board:
    """The state of one mission by key: ``robot/ID``, ``tag/ID``, ``map``, ... For one event loop."""

    def __init__(self) -> None:
        self._values: dict[str, Value] = {}
        self._texts: dict[str, str] = {}
        self._subscriptions: set[Subscription] = set()

    def __len__(self) -> int:
        return len(self._values)

    def get(self, key: str) -> Value | None:
        """Return the value of a key, None when it has none. Values are never changed in place."""
        return self._values.get(key)

    def of_kind(self, kind: str) -> list[Value]:
        """Return the values of all keys ``kind/...``, in the order of their first appearance."""
        return [value for key, value in self._values.items() if key.startswith(f"{kind}/")]

    def publish(self, values: Mapping[str, Value | None]) -> None:
        """Set values; None deletes a key. A value equal to the one that is there changes nothing."""
        changed = []
        for key, value in values.items():
            if self._values.get(key) == value:
                continue
            self._texts.pop(key, None)
            if value is None:
                self._values.pop(key, None)
            else:
                self._values[key] = value
            changed.append(key)
        if changed:
            for subscription in self._subscriptions:
                subscription.note(changed)

    def snapshot(self) -> dict[str, Value]:
        """Return the value of every key."""
        return dict(self._values)

    def subscribe(self) -> Subscription:
        """Return a subscription that sees every change from this moment on.

        Close it, or use it in ``with``.
        """
        subscription = Subscription(self)
        self._subscriptions.add(subscription)
        return subscription

    def unsubscribe(self, subscription: Subscription) -> None:
        """Stop telling a subscription of changes."""
        self._subscriptions.discard(subscription)

    @property
    def subscribers(self) -> int:
        """How many are told of changes."""
        return len(self._subscriptions)

    def snapshot_text(self) -> str:
        """Return the snapshot as a JSON object."""
        return self._object(self._values)

    def changes_text(self, changed: Iterable[str]) -> tuple[str, str]:
        """Return the current values of keys as a JSON object, and those that are gone as a JSON list."""
        there = [key for key in changed if key in self._values]
        gone = [key for key in changed if key not in self._values]
        return self._object(there), json.dumps(gone)

    def _object(self, keys: Iterable[str]) -> str:
        return "{" + ",".join(f"{json.dumps(key)}:{self._text(key)}" for key in keys) + "}"

    def _text(self, key: str) -> str:
        # encoded once, however many are told
        if key not in self._texts:
            self._texts[key] = json.dumps(self._values[key], separators=(",", ":"), allow_nan=False)
        return self._texts[key]


class Subscription:
    """The keys that changed since the subscriber last asked.

    Iterates over (values that were set, deleted keys).
    """

    def __init__(self, board: Board) -> None:
        self._board = board
        self._changed: dict[str, None] = {}  # a set that keeps its order
        self._woken = asyncio.Event()

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __aiter__(self) -> Subscription:
        return self

    async def __anext__(self) -> tuple[dict[str, Value], list[str]]:
        changed = await self.next_keys(None)
        there = {key: value for key in changed if (value := self._board.get(key)) is not None}
        return there, [key for key in changed if key not in there]

    def note(self, keys: Iterable[str]) -> None:
        """Take note of keys that changed."""
        self._changed.update(dict.fromkeys(keys))
        self._woken.set()

    async def next_keys(self, timeout_s: float | None) -> list[str]:
        """Wait for changes and return their keys, none at all when the time is over."""
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                await self._woken.wait()
        return self.take_keys()

    def take_keys(self) -> list[str]:
        """Return the keys that changed since, without waiting."""
        self._woken.clear()
        changed, self._changed = list(self._changed), {}
        return changed

    def close(self) -> None:
        """Stop being told."""
        self._board.unsubscribe(self)
