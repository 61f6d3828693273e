"""How the past is written: a chunk is the whole state at its beginning and then what changed, line by line.

A chunk is JSON: ``{"begins_unix_s", "state": {key: value}, "changes": [line, ...]}``, a line of it
``{"unix_s", "set": {key: value}, "patch": {key: {field: value}}, "splice": {key: {field: [front, back,
middle]}}, "delete": [key, ...]}``. Where a value has the same fields as before, only those that differ are
written; of a list only the middle, between what stays of its front and its back.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

Value = dict[str, Any]


@dataclass(slots=True)
class Change:
    """What differs from one moment to the next."""

    set: dict[str, Value] = field(default_factory=dict)
    patch: dict[str, Value] = field(default_factory=dict)
    splice: dict[str, dict[str, tuple[int, int, list[Any]]]] = field(default_factory=dict)
    delete: list[str] = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.set or self.patch or self.splice or self.delete)

    @classmethod
    def of(cls, line: Mapping[str, Any]) -> Change:
        """Return what a line of a chunk says."""
        return cls(line["set"], line["patch"], line["splice"], line["delete"])

    def text(self, unix_s: float) -> str:
        """Return the line of a chunk."""
        parts = {"set": self.set, "patch": self.patch, "splice": self.splice, "delete": self.delete}
        return encoded({"unix_s": unix_s, **parts})

    def apply(self, state: dict[str, Value]) -> None:
        """Bring a state to what it is after this change; values in it are replaced, not changed."""
        state.update(self.set)
        for key, fields in self.patch.items():
            state[key] = {**state[key], **fields}
        for key, lists in self.splice.items():
            before = state[key]
            whole = {name: _spliced(before[name], *parts) for name, parts in lists.items()}
            state[key] = {**before, **whole}
        for key in self.delete:
            state.pop(key, None)


def between(before: Mapping[str, Value], after: Mapping[str, Value], keys: Iterable[str]) -> Change:
    """Return what has to change in ``before`` for these keys to be as in ``after``."""
    change = Change()
    for key in keys:
        old, new = before.get(key), after.get(key)
        if new is None:
            if old is not None:
                change.delete.append(key)
        elif old is None or old.keys() != new.keys():
            change.set[key] = new
        else:
            _compare(change, key, old, new)
    return change


def _compare(change: Change, key: str, old: Value, new: Value) -> None:
    for name, value in new.items():
        before = old[name]
        if before == value:
            continue
        parts = _parts(before, value) if isinstance(before, list) and isinstance(value, list) else None
        if parts is None:
            change.patch.setdefault(key, {})[name] = value
        else:
            change.splice.setdefault(key, {})[name] = parts


def _parts(old: list[Any], new: list[Any]) -> tuple[int, int, list[Any]] | None:
    """Return how much stays of a list's front and back, and the middle; None where most is new."""
    most = min(len(old), len(new))
    front = next((i for i in range(most) if old[i] != new[i]), most)
    back = next((i for i in range(most - front) if old[-1 - i] != new[-1 - i]), most - front)
    if 2 * (front + back) < len(new) or not front + back:
        return None
    return front, back, new[front : len(new) - back]


def _spliced(old: list[Any], front: int, back: int, middle: list[Any]) -> list[Any]:
    return [*old[:front], *middle, *old[len(old) - back :]]


def first_line(unix_s: float, state: Mapping[str, Value]) -> str:
    """Return the line that a chunk begins with."""
    return encoded({"begins_unix_s": unix_s, "state": state})


def chunk_text(lines: Iterable[str]) -> bytes:
    """Return a chunk of its lines, of which the first is the state."""
    first, *others = lines
    return (first[:-1] + ',"changes":[' + ",".join(others) + "]}").encode()


def sealed(lines: Iterable[str]) -> bytes:
    """Return a chunk as it is kept and sent: gzip, the same bytes for the same lines."""
    return gzip.compress(chunk_text(lines), compresslevel=6, mtime=0)


def encoded(value: object) -> str:
    """Return JSON without blanks."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)
