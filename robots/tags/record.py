"""Our record in a tag: content under a header with a checksum, and under the mission's seal.

Five bytes of header (version, revision, length), two of checksum, the content, eight of the seal: BLAKE2s
under the mission's key over the tag's id, the revision and the content, so that neither content nor a whole
record of another tag can be passed off as the mission's. A record without its seal is shown to people, not
believed.

A chip leaves the reader's field in the middle of a write, so content is written first and the header last:
what was torn has a checksum that does not fit. From 504 bytes on there are two halves written in turn, and
the older one stays whole.
"""

from __future__ import annotations

import hmac
import struct
from binascii import crc_hqx
from dataclasses import dataclass
from hashlib import blake2s

from robots.tags.chip import Chip, Layout

VERSION = 3
HALVES_FROM = 504  # user bytes
_HEADER, _CHECK = struct.Struct(">BHH"), struct.Struct(">H")
_HEAD, _SEAL = _HEADER.size + _CHECK.size, 8
OVERHEAD = _HEAD + _SEAL
_REVISIONS = 1 << 16


class RecordError(ValueError):
    """The bytes are no record of this version, or they are damaged."""


@dataclass(frozen=True, slots=True)
class Record:
    """What a tag says: ``trusted`` where the seal is the mission's."""

    content: bytes
    revision: int
    trusted: bool


def content_bytes(chip: Chip, layout: Layout) -> int:
    """Return how much content a formatted chip holds."""
    return max(0, _half(chip, layout) - OVERHEAD)


def seal(content: bytes, revision: int, tag_id: str, key: bytes) -> bytes:
    """Return the record: content of revision ``revision`` (modulo 65,536) for a tag.

    Raises:
        ValueError: the content is longer than 65,535 bytes.
    """
    if len(content) > 0xFFFF:
        raise ValueError(f"{len(content)} bytes are more than a record holds (65,535)")
    revision %= _REVISIONS
    head = _HEADER.pack(VERSION, revision, len(content))
    rest = content + _seal(content, revision, tag_id, key)
    return head + _CHECK.pack(crc_hqx(head + rest, 0xFFFF)) + rest


def unseal(data: bytes, tag_id: str, key: bytes) -> Record:
    """Return what a record says; bytes after it do not count.

    Raises:
        RecordError: it is none, of another version, or damaged.
    """
    if len(data) < OVERHEAD:
        raise RecordError(f"a record has {OVERHEAD} bytes or more, this one {len(data)}")
    version, revision, length = _HEADER.unpack_from(data)
    if version != VERSION:
        raise RecordError(f"the record is of version {version}; this program reads {VERSION}")
    end = OVERHEAD + length
    if end > len(data):
        raise RecordError("the record is cut off; read the tag again")
    if not _is_whole(data[:end]):
        raise RecordError("the record is damaged or half written: its checksum does not fit; read it again")
    content, seal_of = data[_HEAD : end - _SEAL], data[end - _SEAL : end]
    trusted = hmac.compare_digest(_seal(content, revision, tag_id, key), seal_of)
    return Record(content, revision, trusted)


def split(data: bytes) -> tuple[bytes, ...]:
    """Return the whole records in bytes where one follows another; what is damaged is left out.

    Nothing here needs the mission's key: whether to believe a record is for ``unseal`` to say.
    """
    records, at = [], 0
    while len(data) - at >= OVERHEAD:
        version, _, length = _HEADER.unpack_from(data, at)
        end = at + OVERHEAD + length
        if version != VERSION or end > len(data):
            break
        if _is_whole(data[at:end]):
            records.append(data[at:end])
        at = end
    return tuple(records)


def is_sealed(record: bytes) -> bool:
    """Say whether anybody has put a seal on a record that ``split`` returned; phones have no key to do so."""
    return any(record[-_SEAL:])


def revision_of(record: bytes) -> int:
    """Return the revision of a record that ``split`` returned."""
    return int(_HEADER.unpack_from(record)[1])


def is_newer(revision: int, than: int) -> bool:
    """Compare revisions, which wrap round (RFC 1982)."""
    return 0 < (revision - than) % _REVISIONS < _REVISIONS // 2


def halves(payload: bytes, chip: Chip, layout: Layout) -> list[tuple[int, bytes]]:
    """Return the whole records in a chip's payload with the number of their half, the newest first."""
    size = _half(chip, layout)
    found = []
    for half in range(layout.size // size):
        whole = split(payload[half * size : (half + 1) * size])
        if whole:
            found.append((half, whole[0]))
    if len(found) == 2 and not is_newer(revision_of(found[0][1]), revision_of(found[1][1])):
        found.reverse()
    return found


def all_records(payload: bytes, chip: Chip, layout: Layout) -> tuple[bytes, ...]:
    """Return the whole records in a chip's payload, the newest half first; phones' notes lie behind."""
    size = _half(chip, layout)
    return tuple(
        record
        for half, _ in halves(payload, chip, layout)
        for record in split(payload[half * size : (half + 1) * size])
    )


def plan_writes(
    memory: bytes, chip: Chip, layout: Layout, record: bytes, over: int | None
) -> list[tuple[int, bytes]]:
    """Return the blocks to write so that ``memory`` (user bytes of the chip) holds the record, in this order.

    Args:
        memory: what the chip holds now.
        chip: its kind.
        layout: where the payload lies.
        record: what it is to hold.
        over: the half that holds the newest record, None where there is none; the other one is written.

    Raises:
        ValueError: the record is longer than the room for it.
    """
    size = _half(chip, layout)
    if len(record) > size:
        raise ValueError(f"the record has {len(record)} bytes, the tag room for {size}")
    halves = layout.size // size
    start = layout.start + (0 if over is None or halves == 1 else (over + 1) % halves * size)
    after = memory[:start] + record + memory[start + len(record) :]
    step = chip.block_bytes
    blocks = [
        (at, after[at : at + step])
        for at in range(start // step * step, start + len(record), step)
        if after[at : at + step] != memory[at : at + step]
    ]
    last_of_head = start + _HEAD - 1
    return [b for b in blocks if b[0] > last_of_head] + [b for b in blocks if b[0] <= last_of_head]


def _is_whole(record: bytes) -> bool:
    (check,) = _CHECK.unpack_from(record, _HEADER.size)
    return bool(crc_hqx(record[: _HEADER.size] + record[_HEAD:], 0xFFFF) == check)


def _half(chip: Chip, layout: Layout) -> int:
    return layout.size // 2 if chip.user_bytes >= HALVES_FROM else layout.size


def _seal(content: bytes, revision: int, tag_id: str, key: bytes) -> bytes:
    name = tag_id.encode()
    said = len(name).to_bytes(2, "big") + name + revision.to_bytes(2, "big") + content
    return blake2s(said, digest_size=_SEAL, key=key[:32], person=b"waymark").digest()
