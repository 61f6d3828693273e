"""Maps in tags merge in any order, any number of times, and come back from bytes as they were."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.tags.content import decode_memory, encode_memory, merge_bytes
from robots.tags.map_memory import MAX_WRITERS, TagBelief, WriterMap, merge_maps, pack_maps, unpack_maps
from robots.tags.memory import SIDE, TagMemory, TagMemoryError

names = st.sampled_from(["r1", "r2", "a robot", "é"])
floats = st.floats(-1e6, 1e6, width=32)
beliefs = st.builds(TagBelief, names, floats, floats, floats, floats, floats)
frames = st.one_of(st.just(()), st.tuples(*[floats] * 6))
maps = st.builds(
    WriterMap, names, st.integers(0, 2**32 - 1), st.lists(beliefs, max_size=3).map(tuple), frames
)
sets = st.lists(maps, max_size=4).map(lambda each: merge_maps(tuple(each), ()))


@given(sets, sets, sets)
def test_merging_has_no_order_and_no_count(a, b, c):
    assert merge_maps(a, b) == merge_maps(b, a)
    assert merge_maps(merge_maps(a, b), c) == merge_maps(a, merge_maps(b, c))
    assert merge_maps(a, a) == a


@given(sets)
def test_maps_come_back_bit_for_bit(given_maps):
    assert unpack_maps(pack_maps(given_maps)) == given_maps
    cells = np.ones((SIDE, SIDE), np.uint8)
    memory = TagMemory(cells, given_maps)
    assert decode_memory(encode_memory(memory)) == memory
    assert decode_memory(merge_bytes(encode_memory(memory), encode_memory(TagMemory(cells)))) == memory


def test_a_newer_map_replaces_the_same_writers():
    old, new = WriterMap("r1", 1, (TagBelief("A", 0, 0, 1, 0, 1),)), WriterMap("r1", 2, ())
    assert merge_maps((old,), (new,)) == (new,)


def test_more_writers_than_a_memory_holds_merge_to_what_it_holds():
    many = tuple(WriterMap(f"r{k:03d}", 1, ()) for k in range(MAX_WRITERS + 20))
    assert len(merge_maps(many, ())) == MAX_WRITERS
    assert merge_maps(many[60:], many[:80]) == merge_maps(many, ())


@given(sets, st.binary(min_size=1, max_size=300), st.integers(0, 400))
def test_damaged_bytes_are_refused(given_maps, noise, at):
    whole = encode_memory(TagMemory(np.zeros((SIDE, SIDE), np.uint8), given_maps))
    for bad in (whole[:at] + noise + whole[at:], whole[: -1 - at], noise):
        if not bad or bad == whole:
            continue
        with pytest.raises(TagMemoryError):
            decode_memory(bad)
    for bad in (noise, pack_maps(given_maps) + noise):
        try:
            found = unpack_maps(bad)
        except ValueError:
            continue
        assert pack_maps(found)  # what is understood can be written again


def test_a_place_that_is_not_finite_is_neither_written_nor_read():
    bad = (WriterMap("r1", 1, (TagBelief("A", float("nan"), 0.0, 1.0, 0.0, 1.0),)),)
    with pytest.raises(ValueError, match="not finite"):
        pack_maps(bad)
    with pytest.raises(ValueError, match="six finite numbers"):
        pack_maps((WriterMap("r1", 1, (), (1.0, float("inf"), 0.0, 1.0, 0.0, 1.0)),))
    good = pack_maps((WriterMap("r1", 1, (TagBelief("A", 0.0, 0.0, 1.0, 0.0, 1.0),)),))
    with pytest.raises(ValueError, match="not finite"):
        unpack_maps(good[:-20] + b"\x7f\xc0\x00\x00" + good[-16:])
