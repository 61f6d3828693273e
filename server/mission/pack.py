"""A mission's file in parts, so that a phone fetches again only what has changed."""

from __future__ import annotations

import gzip
import hashlib
import json
from collections.abc import Set

from server.board import Value

_PARTS = {"ground": ("tags", "ways"), "plan": ("map",)}


class Pack:
    """The file as JSON: its parts, each under a name that changes with it, and all that is small.

    ``etag`` changes with any of it.
    """

    def __init__(self, value: Value) -> None:
        self._parts: dict[str, bytes] = {}
        names = {}
        for part, keys in _PARTS.items():
            text = _inner({key: value[key] for key in keys})
            names[part] = _name_of(text)
            self._parts[names[part]] = text
        in_parts = {key for keys in _PARTS.values() for key in keys}
        rest = {key: each for key, each in value.items() if key not in in_parts}
        self._rest = _inner(rest | {"parts": names})
        self.etag = f'W/"{_name_of(self._rest)}"'
        self._zipped: dict[Set[str], bytes] = {}
        self.zipped()

    def plain(self, have: Set[str] = frozenset()) -> bytes:
        """Return the file as JSON without the parts whose names are given."""
        told = [text for name, text in self._parts.items() if name not in have]
        return b"{" + b",".join([self._rest, *told]) + b"}"

    def zipped(self, have: Set[str] = frozenset()) -> bytes:
        """Return the same gzipped, done once for all who have the same."""
        told = frozenset(self._parts) & have
        if told not in self._zipped:
            self._zipped[told] = gzip.compress(self.plain(told), 6, mtime=0)
        return self._zipped[told]


def _inner(value: Value) -> bytes:
    """Return an object's JSON without its braces."""
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()[1:-1]


def _name_of(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:20]
