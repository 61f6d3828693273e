"""What people type for a tag: its id in an alphabet without look-alikes, and a check character after it.

Crockford's base32 leaves out I, L, O and U; who types them is understood. The check character is Horner's
sum over GF(32) with the field's generator 2 (x^5 + x^2 + 1): every wrong character and every swap of two
neighbours changes it (Damm 2004: x -> 2x is totally anti-symmetric there). It begins with 1, so that a
nought in front counts. Links and wires keep the tag's own id; ids with other characters have no short one.
``web/static/phone/short_id.js`` does the same, by the vectors in ``tests/vectors/short_ids.json``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce
from typing import Literal

ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
LONGEST = 12  # characters that people type without a mistake
_VALUES = {letter: k for k, letter in enumerate(ALPHABET)}
_LOOK_ALIKES = str.maketrans("OILU", "011V")
_GAPS = re.compile(r"[\s_.–-]+")
_GROUP = 4


@dataclass(frozen=True, slots=True)
class Understood:
    """The tags that somebody may have meant; where there is none, whether the check character fits."""

    tag_ids: tuple[str, ...]
    trouble: Literal["", "mistyped", "unknown"]


def folded(text: str) -> str | None:
    """Return the text without case, gaps and look-alikes; None where other characters are in it, or none."""
    plain = _GAPS.sub("", text).upper().translate(_LOOK_ALIKES)
    return plain if plain and all(letter in _VALUES for letter in plain) else None


def check_character(plain: str) -> str:
    """Return the check character of a folded text."""
    return ALPHABET[_doubled(_sum(plain))]


def short_id(tag_id: str) -> str | None:
    """Return what to print for a tag, "A017-G" or "7F3A-22K1-M"; None where its id is not for typing."""
    plain = folded(tag_id)
    if plain is None or len(plain) > LONGEST:
        return None
    groups = [plain[k : k + _GROUP] for k in range(0, len(plain), _GROUP)]
    return "-".join([*groups, check_character(plain)])


def understood(typed: str, tag_ids: Iterable[str]) -> Understood:
    """Return the tags that somebody means: by their id, or by their id and its check character."""
    exact, plain = typed.strip(), folded(typed)
    meant = sorted({tag_id for tag_id in tag_ids if tag_id == exact or (plain and _is_for(plain, tag_id))})
    if meant:
        return Understood(tuple(meant), "")
    fits = plain is not None and len(plain) > 1 and _sum(plain) == 0
    return Understood((), "unknown" if fits else "mistyped")


def _is_for(plain: str, tag_id: str) -> bool:
    own = folded(tag_id)
    return own is not None and (plain == own or plain == own + check_character(own))


def _sum(plain: str) -> int:
    return reduce(lambda total, letter: _doubled(total) ^ _VALUES[letter], plain, 1)


def _doubled(value: int) -> int:
    return value << 1 if value < 16 else (value << 1) ^ 0b100101
