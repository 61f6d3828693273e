"""Messages of the team: what goes in comes out, and nothing else gets in."""

import zlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.exploration.team.team_message import (
    MAX_BYTES,
    MAX_TILES,
    TILE_BYTES,
    Patch,
    TeamMessage,
    TeamMessageError,
    Tile,
    decode_message,
    encode_message,
)
from robots.se2 import Pose2

metres = st.floats(-1e5, 1e5)
names = st.text(st.characters(codec="utf-8"), min_size=1, max_size=20)
tiles = st.builds(
    Tile,
    st.integers(-32_000, 32_000),
    st.integers(-32_000, 32_000),
    st.integers(11, 90),
    st.binary(min_size=TILE_BYTES, max_size=TILE_BYTES),
)


@st.composite
def messages(draw):
    known = draw(st.dictionaries(names, st.integers(0, 2**31 - 1), max_size=4))
    origins = draw(st.lists(st.sampled_from(sorted(known)), unique=True)) if known else []
    patches = [Patch(name, 10, 90, tuple(draw(st.lists(tiles, max_size=2)))) for name in origins]
    return TeamMessage(
        draw(names),
        draw(st.integers(0, 2**31 - 1)),
        draw(st.floats(-1e12, 1e12)),
        Pose2(draw(metres), draw(metres), draw(st.floats(-3.1, 3.1))),
        draw(st.none() | st.tuples(metres, metres)),
        tuple(known.items()),
        tuple(patches),
        draw(st.booleans()),
        draw(st.booleans()),
    )


TILE = Tile(0, -1, 5, bytes(TILE_BYTES))
MESSAGE = TeamMessage(
    "r1", 7, 12.5, Pose2(1.0, 2.0, 0.5), (3.0, 4.0), (("r1", 20),), (Patch("r1", 3, 9, (TILE,)),)
)


def with_body(raw: bytes) -> bytes:
    body = zlib.compress(raw)
    return b"WTM\x01" + zlib.crc32(body).to_bytes(4, "little") + body


@given(messages())
@settings(max_examples=60, deadline=None)
def test_what_is_said_is_heard(message):
    assert decode_message(encode_message(message)) == message


@given(st.binary(max_size=400), st.integers(0, 400), st.integers(1, 255))
@settings(max_examples=150, deadline=None)
def test_whatever_a_radio_makes_of_it_there_is_a_clear_answer(noise, at, flip):
    data = bytearray(encode_message(MESSAGE))
    data[at % len(data)] ^= flip
    for garbled in (noise, bytes(data), bytes(data[: at % len(data)]), with_body(noise)):
        with pytest.raises(TeamMessageError, match=r"^it |^a tile|^there is more|^its pose"):
            decode_message(garbled)


@pytest.mark.parametrize(
    "changes",
    [
        {"pose": Pose2(float("nan"), 0.0, 0.0)},
        {"pose": Pose2(0.0, float("inf"), 0.0)},
        {"pose": Pose2(0.0, 2e6, 0.0)},
        {"goal_m": (0.0, float("nan"))},
        {"stamp_s": float("inf")},
        {"number": -1},
        {"number": 2**31},
        {"robot_id": ""},
        {"robot_id": "r" * 300},
        {"known": (("r1", 1), ("r1", 2))},
        {"known": tuple((f"r{k}", 1) for k in range(200))},
        {"patches": (Patch("r9", 0, 1, ()),)},
        {"patches": (Patch("r1", 0, 1, ()), Patch("r1", 1, 2, ()))},
        {"patches": (Patch("r1", 0, 9, (Tile(0, 0, 1, b"short"),)),)},
        {"patches": (Patch("r1", 5, 9, (Tile(0, 0, 4, bytes(TILE_BYTES)),)),)},
        {"patches": (Patch("r1", 0, 9, (Tile(40_000, 0, 4, bytes(TILE_BYTES)),)),)},
        {"patches": (Patch("r1", 0, 9, (Tile(0, 0, 4, bytes(TILE_BYTES)),) * (MAX_TILES + 1)),)},
    ],
)
def test_what_cannot_be_is_refused_before_it_is_said(changes):
    fields = {name: getattr(MESSAGE, name) for name in TeamMessage.__slots__} | changes
    with pytest.raises(TeamMessageError):
        encode_message(TeamMessage(**fields))


def test_a_huge_one_is_refused_unread():
    with pytest.raises(TeamMessageError, match=f"more than {MAX_BYTES}"):
        decode_message(bytes(MAX_BYTES + 1))
    with pytest.raises(TeamMessageError, match="longer than a message may be"):
        decode_message(with_body(bytes(2 * 10**7)))
