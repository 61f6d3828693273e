"""Whether a decoded value is what its class says: bytes from elsewhere can hold anything under any name."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from functools import lru_cache
from math import isfinite
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

_MOST = 1e12  # of any number: seconds since 1970 are 2e9


def fault(value: object, hint: Any, where: str) -> str | None:
    """Return what in the value contradicts the type, None when nothing does.

    Numbers have to be finite and no more than 1e12 either way, arrays to be of one dimension; whatever is in
    an array is its reader's to judge.
    """
    origin = get_origin(hint)
    if origin in (Union, UnionType):
        found = [fault(value, option, where) for option in get_args(hint)]
        return None if None in found else _narrowest(value, get_args(hint), found)
    if hint is None or hint is NoneType:
        return None if value is None else f"{where} has to be left out"
    if origin is Literal:
        return None if value in get_args(hint) else f"{where} is {value!r}"
    if origin is tuple:
        if not isinstance(value, tuple):
            return f"{where} is no list"
        inner = get_args(hint)[0]
        return next((text for item in value if (text := fault(item, inner, where)) is not None), None)
    if origin is np.ndarray:
        wanted = np.dtype(get_args(get_args(hint)[1])[0])
        fits = isinstance(value, np.ndarray) and value.dtype == wanted and value.ndim == 1
        return None if fits else f"{where} is no row of {wanted}"
    if is_dataclass(hint):
        return _fault_of_fields(value, hint, where)
    if hint in (int, float):
        good = isinstance(value, int if hint is int else int | float) and not isinstance(value, bool)
        return None if good and _in_range(value) else f"{where} is no usable number"
    return None if type(value) is hint else f"{where} is no {hint.__name__}"


def _fault_of_fields(value: object, cls: Any, where: str) -> str | None:
    if not _is_exactly(value, cls):
        return f"{where} is no {cls.__name__}"
    hints = _hints(cls)
    found = (fault(getattr(value, item.name), hints[item.name], item.name) for item in fields(cls))
    return next((text for text in found if text is not None), None)


def _narrowest(value: object, options: tuple[Any, ...], found: list[str | None]) -> str | None:
    """Prefer what is wrong inside the class that was meant."""
    return next(
        (text for option, text in zip(options, found, strict=True) if type(value) is option), found[0]
    )


def _in_range(value: Any) -> bool:
    try:
        return isfinite(value) and abs(value) <= _MOST
    except OverflowError:  # a whole number beyond all floats
        return False


def _is_exactly(value: object, cls: Any) -> bool:
    return type(value) is cls


@lru_cache
def _hints(cls: type[Any]) -> dict[str, Any]:
    return get_type_hints(cls)
