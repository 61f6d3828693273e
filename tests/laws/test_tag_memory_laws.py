"""Tag memories merge like a set grows: in any order, any number of times, and nothing is lost.

On chips that are too small for all of it, what stays is the same whatever was merged first.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.tags.content import decode_memory, encode_memory, merge_bytes
from robots.tags.map_memory import TagBelief, WriterMap, merge_maps
from robots.tags.marks import MAX_NAME, Note, Notes, Pass, VictimMark, merged_marks
from robots.tags.memory import CENTRED, CLOSED, SIDE, VISITED_REACH, TagMemory, TagMemoryError
from robots.tags.record import seal
from robots.tags.sealed import close_memory, open_memory
from robots.tags.window import resized

KEY = b"mission"
ROOMS = st.sampled_from([0, 1, 2, 3, 4, 5, 6, 7, 52, 92, 193, 196, 216, 250, 256, 408, 472, 4056])
names = st.sampled_from(["r1", "r2", "r10", "a robot", "é"])
floats = st.floats(-1e6, 1e6, width=32)
beliefs = st.builds(TagBelief, names, floats, floats, floats, floats, floats)
maps = st.builds(WriterMap, names, st.integers(0, 3), st.lists(beliefs, max_size=6).map(tuple))
small = st.integers(0, 9)
victims = st.builds(VictimMark, small, small, st.integers(-400, 400), small, small)
passes = st.builds(Pass, small, small, st.integers(-128, 127), small, small)
notes = st.builds(Note, st.integers(1, 6), names, st.text(max_size=20))


@st.composite
def memories(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    side = draw(st.sampled_from(range(1, SIDE + 1, 2)))
    cells = rng.integers(0, CLOSED + 1, (side, side)).astype(np.uint8)
    cells[rng.random(cells.shape) < draw(st.floats(0.0, 1.0))] = 0
    visited = rng.integers(0, 3, (2 * draw(st.integers(0, VISITED_REACH)) + 1,) * 2).astype(np.uint8)
    return TagMemory(
        cells,
        merge_maps(tuple(draw(st.lists(maps, max_size=4))), ()),
        merged_marks(*draw(st.lists(victims, max_size=8))),
        Notes(tuple(draw(st.lists(notes, max_size=6)))).merge(Notes()),
        merged_marks(*draw(st.lists(passes, max_size=8))),
        visited * np.uint8(draw(st.booleans())),
        draw(st.sampled_from([CENTRED, 0, 7, 255, 0x188, 0x207])) if cells.any() else CENTRED,
    )


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
    assert decode_memory(merge_bytes(b"", encode_memory(a))) == a


@given(memories(), memories())
def test_merge_loses_nothing_and_invents_nothing(a, b):
    b = replace(b, phase=a.phase)  # on one lattice
    merged = a.merge(b).cells
    first, second = resized(a.cells, len(merged)), resized(b.cells, len(merged))
    assert (merged >= first).all()
    assert (merged >= second).all()
    assert ((merged == first) | (merged == second)).all()


@given(memories(), memories(), memories(), ROOMS)
def test_on_a_small_chip_the_laws_hold_too(a, b, c, room):
    def merged(first, second):
        return first.merge(second).fit(room)

    small = [each.fit(room) for each in (a, b, c)]
    assert merged(small[0], small[1]) == merged(small[1], small[0])
    assert merged(merged(*small[:2]), small[2]) == merged(small[0], merged(*small[1:]))
    assert merged(small[0], small[0]) == small[0]
    assert merged(small[0], small[1]) == a.merge(b).fit(room)


@given(memories(), ROOMS)
def test_what_fits_has_room(a, room):
    data = encode_memory(a.fit(room))
    assert len(data) <= max(room, 3)
    assert decode_memory(data) == a.fit(room)
    assert a.fit(room).fit(room) == a.fit(room)


@given(memories())
def test_bytes_come_back(a):
    assert decode_memory(encode_memory(a)) == a


@given(st.binary(max_size=300))
def test_no_bytes_break_the_reader(data):
    for read in (decode_memory, lambda noise: open_memory(noise, "A", KEY)):
        with suppress(TagMemoryError):
            read(data)


@given(memories(), memories(), st.integers(0, 65_535), st.integers(1, 5))
def test_the_newest_record_under_the_missions_seal_counts(a, b, revision, later):
    old = close_memory(a, revision, "A", KEY, 9000)
    new = close_memory(b, revision + later, "A", KEY, 9000)
    forged = close_memory(TagMemory(np.full((5, 5), CLOSED, np.uint8)), revision + 9, "A", b"stranger", 5000)
    for data in (old + new, new + old, old + new + forged, forged + new + old):
        said = open_memory(data, "A", KEY)
        assert (said.memory, said.trusted) == (b.fit(9000), True)
        newest = 9 if forged in data and data.find(forged) >= 0 else later
        assert said.next_revision == (revision + newest) % 65_536 + 1
    said = open_memory(forged, "A", KEY)
    assert not said.trusted
    with pytest.raises(TagMemoryError, match="begins with 64"):
        open_memory(seal(b"\x01hello", 0, "A", KEY), "A", KEY)
    with pytest.raises(TagMemoryError, match="damaged or half written"):
        open_memory(old[:-1], "A", KEY)


@given(st.integers(1, 12), st.integers(0, 40), ROOMS)
def test_many_robots_with_many_tags_share_the_room(robots, tags, room):
    full = tuple(
        WriterMap(f"robot-{k:010d}", 1, tuple(TagBelief(f"tag-{j:012d}", 1, 2, 3, 0, 4) for j in range(tags)))
        for k in range(robots)
    )
    fitted = TagMemory(np.full((SIDE, SIDE), CLOSED, np.uint8), full).fit(room)
    assert len(encode_memory(fitted)) <= max(room, 3)
    assert len({len(each.beliefs) for each in fitted.maps}) <= 1


@given(memories(), memories(), ROOMS)
def test_who_has_room_for_all_loses_nothing_to_a_small_chip(a, b, room):
    assert a.merge(a.fit(room).uncut()) == a
    both = a.merge(b)
    assert both.merge(a.fit(room).uncut()).merge(b.fit(room).uncut()) == both


@given(st.lists(notes, max_size=30), st.integers(16, 120))
def test_the_newest_notes_stay(found, room):
    whole = Notes(tuple(found)).merge(Notes())
    kept = whole.fit(room)
    assert kept.notes == whole.notes[: len(kept.notes)]
    assert (kept.gone is None) == (kept.notes == whole.notes)
    assert all(len(note.author.encode()) <= MAX_NAME for note in kept.notes)
