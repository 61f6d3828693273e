"""A chip gives back what was written, whatever tears the writing, and no bytes break its reader."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.tags.chip import CHIPS, ChipError, format_chip, read_chip
from robots.tags.reader import SimulatedTag, TagGoneError, read_tag, write_tag
from robots.tags.record import HALVES_FROM, Record, RecordError, content_bytes, seal, unseal

LINK = "https://usar.example/t/7F3A"
KEY, OTHER_KEY = b"mission", b"another"
chips = st.sampled_from(list(CHIPS.values()))
small_contents = st.binary(max_size=5)


@given(chips, st.data())
def test_what_is_written_is_read(chip, data):
    tag = SimulatedTag.formatted(chip, LINK)
    room = content_bytes(chip, format_chip(chip, LINK)[1])
    contents = data.draw(st.lists(st.binary(max_size=min(room, 300)), min_size=1, max_size=4))
    for revision, content in enumerate(contents):
        record = seal(content, revision, "A4", KEY)
        write_tag(tag, record)
        said = read_tag(tag)
        assert said.records[0] == record
        assert (said.link, said.room_bytes, said.damaged) == (LINK, room, False)


@given(chips, small_contents, small_contents, st.integers(0, 12))
def test_a_torn_write_never_says_what_was_not_written(chip, before, after, blocks):
    tag = SimulatedTag.formatted(chip, LINK)
    old, new = seal(before, 0, "A4", KEY), seal(after, 1, "A4", KEY)
    write_tag(tag, old)
    tag.blocks_left = blocks
    try:
        write_tag(tag, new)
    except TagGoneError:
        torn = True
    else:
        torn = False
    tag.blocks_left = None
    said = read_tag(tag)
    if not torn:
        assert said.records[0] == new
    elif chip.user_bytes >= HALVES_FROM:
        assert said.records == (old,)
    else:
        assert said.records == ((old,) if not said.damaged else ())
    write_tag(tag, new)  # held still this time
    assert read_tag(tag).records[0] == new


@given(st.binary(max_size=60), st.integers(0, 70_000), st.text(max_size=8))
def test_records_come_back(content, revision, tag_id):
    data = seal(content, revision, tag_id, KEY)
    assert unseal(data + b"rest", tag_id, KEY) == Record(content, revision % 65_536, True)


@given(st.binary(min_size=1, max_size=60), st.integers(0, 65_535), st.data())
def test_a_strangers_record_is_read_but_not_believed(content, revision, data):
    for tag_id, key in (
        ("A4", OTHER_KEY),
        ("A5", KEY),
        ("A4", b""),
    ):  # forged, copied from another tag, unsealed
        assert unseal(seal(content, revision, "A4", KEY), tag_id, key) == Record(content, revision, False)
    sealed = bytearray(seal(content, revision, "A4", KEY))
    at = data.draw(st.integers(0, len(sealed) - 1))
    sealed[at] ^= data.draw(st.integers(1, 255))
    with pytest.raises(RecordError):  # bits that flipped: the checksum finds up to 16 in a row
        unseal(bytes(sealed), "A4", KEY)


@given(st.binary(max_size=80))
def test_no_bytes_break_the_readers(data):
    try:
        _, layout = read_chip(data)
    except ChipError:
        pass
    else:
        assert 0 <= layout.start <= layout.start + layout.size <= len(data)
    with contextlib.suppress(RecordError):
        assert not unseal(data, "A4", KEY).trusted


@given(chips, st.data())
def test_damage_anywhere_is_told_or_harmless(chip, data):
    tag = SimulatedTag.formatted(chip, LINK)
    record = seal(b"hello", 0, "A4", KEY)
    write_tag(tag, record)
    at = data.draw(st.integers(0, min(chip.user_bytes, 200) // 4 - 1)) * 4
    block = data.draw(st.binary(min_size=4, max_size=4))
    tag.write(at, block)
    try:
        said = read_tag(tag)
    except ChipError:
        return
    assert said.records in ((record,), ())
