"""Tag memories merge like a set grows: in any order, any number of times, and nothing is lost."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robots.tags.memory import (
    CLOSED,
    SIDE,
    TagMemory,
    TagMemoryError,
    decode_memory,
    encode_memory,
    merge_bytes,
)


@st.composite
def memories(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    cells = rng.integers(0, CLOSED + 1, (SIDE, SIDE)).astype(np.uint8)
    cells[rng.random(cells.shape) < draw(st.floats(0.0, 1.0))] = 0
    return TagMemory(cells)


@given(memories(), memories())
def test_merge_is_commutative(a, b):
    assert a.merge(b) == b.merge(a)
    assert merge_bytes(encode_memory(a), encode_memory(b)) == merge_bytes(encode_memory(b), encode_memory(a))


@given(memories(), memories(), memories())
def test_merge_is_associative(a, b, c):
    assert a.merge(b).merge(c) == a.merge(b.merge(c))


@given(memories(), memories())
def test_merge_is_idempotent(a, b):
    assert a.merge(a) == a
    assert a.merge(b).merge(b) == a.merge(b)


@given(memories())
def test_an_empty_memory_adds_nothing(a):
    assert a.merge(TagMemory.empty()) == a
    assert merge_bytes(b"", encode_memory(a)) == encode_memory(a)


@given(memories(), memories())
def test_merge_loses_nothing_and_invents_nothing(a, b):
    merged = a.merge(b).cells
    assert (merged >= a.cells).all()
    assert (merged >= b.cells).all()
    assert ((merged == a.cells) | (merged == b.cells)).all()


@given(memories())
def test_bytes_come_back(a):
    data = encode_memory(a)
    assert len(data) == 186
    assert decode_memory(data) == a
    assert decode_memory(data).cells.dtype == np.uint8
    assert encode_memory(decode_memory(data)) == data


@given(memories(), st.integers(0, 185), st.integers(1, 255))
def test_any_changed_byte_is_refused_or_means_the_same(a, at, change):
    """A checksum of 16 bits misses nothing that happens to one byte."""
    data = bytearray(encode_memory(a))
    data[at] ^= change
    try:
        decode_memory(bytes(data))
    except TagMemoryError:
        return
    raise AssertionError(f"byte {at} changed by {change} was not noticed")


@given(st.binary(min_size=1, max_size=400))
def test_strangers_bytes_are_refused(data):
    try:
        decode_memory(data)
    except TagMemoryError:
        return
    raise AssertionError("read a memory that nobody wrote")
