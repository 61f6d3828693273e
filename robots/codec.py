"""Values of ``robots.types`` to bytes and back, exactly.

For the observation log, agent processes and snapshots. JSON with a class name beside each dataclass and
arrays as base64 of their little-endian bytes, so floats survive bit for bit. Only the classes listed here are
ever built, whatever the bytes say.
"""

from __future__ import annotations

import base64
import json
from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any, TypeVar

import numpy as np

from robots import config, graph_report, orders, scan_config, se2, types
from robots.exploration import settings
from robots.team import types as team_types

T = TypeVar("T")

_CLASSES: dict[str, type[Any]] = {
    cls.__name__: cls
    for module in (se2, types, orders, graph_report, config, scan_config, settings, team_types)
    for cls in vars(module).values()
    if isinstance(cls, type) and is_dataclass(cls) and cls.__module__ == module.__name__
}
CHAIN_START = bytes(32)
_DTYPES = {"f8": "<f8", "f4": "<f4", "i8": "<i8", "i4": "<i4", "i1": "|i1", "u1": "|u1"}


class CodecError(ValueError):
    """The bytes are not what this codec wrote."""


def encode(value: object) -> bytes:
    """Return the bytes of a dataclass of ``robots.types``, ``robots.se2``, ``robots.config`` or the team's.

    Raises:
        TypeError: it holds something that cannot be stored exactly.
    """
    return _ENCODER.encode(value).encode()


def decode(data: bytes, expected: type[T]) -> T:
    """Return the value that ``encode`` turned into ``data``.

    Raises:
        CodecError: the bytes are damaged, or hold another class than ``expected``.
    """
    try:
        value = json.loads(data, object_hook=_rich)
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise CodecError(f"not a stored {expected.__name__}: {error}") from error
    if not isinstance(value, expected):
        raise CodecError(f"expected a stored {expected.__name__}, found a {type(value).__name__}")
    return value


def chained(digest: bytes, data: bytes) -> bytes:
    """Return the digest of a chain of encoded values after one more; ``CHAIN_START`` begins it."""
    return sha256(digest + data).digest()


def _plain(value: object) -> dict[str, Any]:
    """Return what JSON's own types hold of a value that is not one of them, one level deep."""
    names = _FIELDS.get(type(value))
    if names is not None:
        plain: dict[str, Any] = {"_": type(value).__name__}
        for name in names:
            plain[name] = item = getattr(value, name)
            if type(item) is dict:
                raise TypeError("cannot store a dict")
        return plain
    if isinstance(value, np.ndarray):
        kind = value.dtype.kind + str(value.dtype.itemsize)
        if kind not in _DTYPES:
            raise TypeError(f"cannot store an array of {value.dtype}")
        data = np.ascontiguousarray(value).astype(_DTYPES[kind], copy=False).tobytes()
        return {"a": kind, "s": value.shape, "b": base64.b64encode(data).decode()}
    if isinstance(value, bytes):
        return {"b": base64.b64encode(value).decode()}
    raise TypeError(f"cannot store a {type(value).__name__}")


def _rich(plain: dict[str, Any]) -> Any:
    """Return the value of a JSON object whose own objects are values already."""
    name = plain.pop("_", None)
    if name is not None:
        return _CLASSES[name](
            **{key: _tuples(item) if type(item) is list else item for key, item in plain.items()}
        )
    data = base64.b64decode(plain["b"], validate=True)
    if "a" in plain:
        return np.frombuffer(data, dtype=_DTYPES[plain["a"]]).reshape(plain["s"]).copy()
    return data


def _tuples(items: list[Any]) -> tuple[Any, ...]:
    return tuple(_tuples(item) if type(item) is list else item for item in items)


_FIELDS = {cls: tuple(item.name for item in fields(cls)) for cls in _CLASSES.values()}
# Values are frozen, so that none holds itself.
_ENCODER = json.JSONEncoder(separators=(",", ":"), default=_plain, check_circular=False)
