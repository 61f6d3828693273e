"""Formatted chips: what NFC Forum's papers ask for, and how much room they leave."""

import itertools

import pytest

from robots.tags.chip import CHIPS, ChipError, chip_of, format_chip, read_chip
from robots.tags.reader import SimulatedTag, read_tag, write_tag
from robots.tags.record import OVERHEAD, content_bytes, plan_writes, seal

LINK = "https://usar.example/t/7F3A"


def test_a_chip_of_2048_bits_byte_by_byte():
    data, layout = format_chip(chip_of(2048), LINK)
    assert data[:4] == bytes.fromhex("e1401f00")  # 31 times 8 bytes
    assert data[4:6] == bytes([0x03, 245])  # one NDEF message
    assert data[6:30] == bytes.fromhex("9101145504") + b"usar.example/t/7F3A"
    assert data[30:39] == bytes([0x54, 6, 212]) + b"u.io:t"
    assert (layout.start, layout.size) == (39, 212)
    assert data[251] == 0xFE
    assert len(data) == 256


def test_the_room_for_content_of_every_chip():
    room = {bits: content_bytes(chip, format_chip(chip, LINK)[1]) for bits, chip in CHIPS.items()}
    assert room == {512: 5, 896: 53, 1152: 93, 2048: 197, 4032: 216, 7104: 408, 8192: 472, 65536: 4056}


def test_longer_links_leave_less_room():
    for bits in CHIPS:
        chip, rooms = chip_of(bits), []
        for length in range(0, 230):
            try:
                data, layout = format_chip(chip, "https://" + "a" * length)
            except ChipError:
                assert bits < 4032
                break
            assert read_chip(data) == ("https://" + "a" * length, layout)
            rooms.append(layout.size)
        assert sorted(rooms, reverse=True) == rooms
        assert all(a - b <= 6 for a, b in itertools.pairwise(rooms))


@pytest.mark.parametrize(
    ("link", "message"),
    [("https://" + "a" * 200, "make it shorter"), ("https://ä.example", "has to be ASCII")],
)
def test_links_that_do_not_fit_are_refused(link, message):
    with pytest.raises(ChipError, match=message):
        format_chip(chip_of(512), link)


def test_unknown_capacities_are_named():
    with pytest.raises(ChipError, match="no chip has 1000 bits; known are 512, 896, 1152, 2048"):
        chip_of(1000)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "end too early"),
        (bytes(16), "end too early"),
        (bytes.fromhex("e1401f00fe"), "is empty"),
        (bytes.fromhex("e1401f000310d1"), "runs beyond its end"),
        (bytes.fromhex("e1401f000304d101095500fe"), "a record runs beyond its message"),
        (bytes.fromhex("e1401f000305d101015500fe"), "no record of ours"),
    ],
)
def test_foreign_and_damaged_chips_are_told_apart(data, message):
    with pytest.raises(ChipError, match=message):
        read_chip(data)


def test_a_foreign_record_before_ours_is_passed_over():
    data, layout = format_chip(chip_of(896), LINK)
    foreign = bytes.fromhex("9a0101017478") + b"!"  # begins the message, short, with an id: media type "t"
    assert foreign[0] & 0x08
    uri_end = layout.start - 9
    message = foreign + bytes([data[6] & 0x7F]) + data[7:uri_end] + data[uri_end : layout.start + layout.size]
    moved = data[:4] + bytes([0x03, len(message)]) + message + b"\xfe"
    link, found = read_chip(moved)
    assert link == LINK
    assert found.size == layout.size
    assert found.start == layout.start + len(foreign)


def test_a_write_touches_only_blocks_that_change_and_the_header_last():
    chip = chip_of(2048)
    memory, layout = format_chip(chip, LINK)
    writes = plan_writes(memory, chip, layout, seal(b"x" * 40, 0, "A", b""), None)
    assert all(at % 4 == 0 and len(block) == 4 for at, block in writes)
    assert [at for at, _ in writes][-3:] == [36, 40, 44]  # 39..45 hold the header
    tag = SimulatedTag.formatted(chip, LINK)
    write_tag(tag, seal(b"x" * 150, 0, "A", b""))
    before = tag.blocks_written
    write_tag(tag, seal(b"x" * 149 + b"y", 1, "A", b""))
    assert tag.blocks_written - before <= 2 + 3 + 3  # the byte, header, seal


def test_halves_are_written_in_turn_and_the_newer_comes_first_also_when_numbers_wrap():
    chip = chip_of(4032)
    _, layout = format_chip(chip, LINK)
    for first in (1, 65_533, 65_534, 65_535):
        tag = SimulatedTag.formatted(chip, LINK)
        records = [seal(bytes([k]), first + k, "A", b"k") for k in range(4)]
        for k, record in enumerate(records):
            write_tag(tag, record)
            assert read_tag(tag).records == tuple(records[max(0, k - 1) : k + 1][::-1])
            at = layout.start + (k % 2) * (layout.size // 2)
            assert tag.read()[at : at + len(record)] == record


def test_what_does_not_fit_is_refused_and_changes_nothing():
    tag = SimulatedTag.formatted(chip_of(512), LINK)
    record = seal(b"12345", 0, "A", b"k")
    write_tag(tag, record)
    with pytest.raises(ValueError, match=f"has {6 + OVERHEAD} bytes, the tag room for 20"):
        write_tag(tag, seal(b"123456", 1, "A", b"k"))
    assert read_tag(tag).records == (record,)
    with pytest.raises(ValueError, match="are no block of this chip"):
        tag.write(2, b"1234")
    with pytest.raises(ValueError, match="more than a record holds"):
        seal(bytes(65_536), 0, "A", b"")
