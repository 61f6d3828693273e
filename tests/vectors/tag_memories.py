"""Payloads of tags and what they say, for everything that reads them: Python here, JavaScript on the phone.

`python -m tests.vectors.tag_memories` writes the file anew.
"""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from robots.tags.chip import CHIPS, format_chip
from robots.tags.content import encode_memory
from robots.tags.describe import describe, sentences
from robots.tags.map_memory import TagBelief, WriterMap, merge_maps
from robots.tags.marks import Note, Notes, Pass, VictimMark, merged_marks
from robots.tags.memory import CENTRED, REACH, TagMemory, TagMemoryError
from robots.tags.reader import SimulatedTag, TagGoneError, read_tag, write_tag
from robots.tags.record import content_bytes, seal
from robots.tags.sealed import close_memory, open_memory

FILE = Path(__file__).with_suffix(".json")
LINK, TAG, KEY = "https://usar.example/t/A4", "A4", b"mission"
_WORDS = (
    "gas",
    "Treppe zerstört",
    "stairs <b>down</b>",
    "声",
    "﻿marked",
    "",
    "a\nb",
    "\u202eturned a\u0301\u0302\u0303",
)


def drawn(rng: np.random.Generator, side: int) -> TagMemory:
    """Return a memory drawn by chance."""
    cells = rng.integers(0, 3, (side, side)).astype(np.uint8)
    cells[rng.random(cells.shape) < rng.random()] = 0
    visited = rng.integers(0, 3, (2 * int(rng.integers(0, 11)) + 1,) * 2).astype(np.uint8)

    def whole(low: int, high: int) -> int:
        return int(rng.integers(low, high))

    victims = [
        VictimMark(whole(0, 256), whole(0, 65536), whole(-400, 400), whole(-400, 400), whole(0, 65536))
        for _ in range(whole(0, 6))
    ]
    passes = [
        Pass(whole(1, 9), whole(0, 5), whole(-128, 128), whole(-2, 3), whole(0, 65536))
        for _ in range(whole(0, 6))
    ]
    notes = [
        Note(whole(1, 9), str(rng.choice(["ann", "r1", "é"])), str(rng.choice(_WORDS)))
        for _ in range(whole(0, 5))
    ]
    maps = [
        WriterMap(
            f"r{k}",
            whole(0, 2**32),
            tuple(
                TagBelief(f"T{j}", *map(float, rng.normal(0, 9, 5).astype(np.float32)))
                for j in range(whole(0, 5))
            ),
            tuple(map(float, rng.normal(0, 1, 6).astype(np.float32))) if rng.random() < 0.5 else (),
        )
        for k in range(whole(0, 3))
    ]
    phase = int(rng.choice([CENTRED, 0, 255, 0x188, 0x211])) if cells.any() else CENTRED
    return TagMemory(
        cells, merge_maps(tuple(maps), ()), merged_marks(*victims), Notes(tuple(notes)).merge(Notes()),
        merged_marks(*passes), visited * np.uint8(rng.random() < 0.7), phase,
    )  # fmt: skip


def expected(payload: bytes, chip_bits: int) -> dict[str, Any]:
    """Return what the Python codec says of a payload on a chip, to somebody without the mission's key."""
    chip = CHIPS[chip_bits]
    if not any(payload):
        return {"condition": "empty", "memory": None, "sentences": []}
    data, layout = format_chip(chip, LINK)
    held = data[: layout.start] + payload + data[layout.start + layout.size :]
    try:
        records = read_tag(SimulatedTag(chip, held)).records
        if not records:
            raise TagMemoryError("no record is whole")
        memory = describe(open_memory(b"".join(records), TAG, b"").memory)
    except TagMemoryError:
        return {"condition": "unreadable", "memory": None, "sentences": []}
    return {"condition": "read", "memory": memory, "sentences": sentences(memory)}


def vectors() -> list[dict[str, Any]]:
    """Return name, payload and meaning of each."""
    rng = np.random.default_rng(5)
    made = [("a formatted tag", 2048, bytes(format_chip(CHIPS[2048], LINK)[1].size))]
    for bits in (896, 2048, 4032, 8192, 65536):
        for writes in (1, 2, 3):
            tag = SimulatedTag.formatted(CHIPS[bits], LINK)
            room = content_bytes(CHIPS[bits], format_chip(CHIPS[bits], LINK)[1])
            for write in range(writes):
                revision = (65534 if writes == 3 else 7) + write
                record = close_memory(drawn(rng, 9).fit(room), revision, TAG, KEY, room)
                write_tag(tag, record)
            made.append((f"{writes} writes to {bits} bits", bits, payload_of(tag, bits)))
            tag.blocks_left = int(rng.integers(1, 8))
            with suppress(TagGoneError):
                write_tag(tag, close_memory(drawn(rng, 9), 9, TAG, KEY, room))
            made.append((f"torn after {writes} writes to {bits} bits", bits, payload_of(tag, bits)))
    made.append(
        ("the widest window", 65536, padded(seal(encode_memory(drawn(rng, 2 * REACH + 1)), 1, TAG, KEY)))
    )
    contents = [encode_memory(drawn(rng, 5).fit(150)) for _ in range(40)]
    for k, content in enumerate(contents):
        for j in range(2):
            spoilt = bytearray(content)
            for _ in range(1 + j):
                spoilt[int(rng.integers(len(spoilt)))] ^= 1 << int(rng.integers(8))
            made.append((f"sealed nonsense {k}.{j}", 65536, padded(seal(bytes(spoilt), 1, TAG, KEY))))
    made.append(("of version 2", 2048, b"\x02" + padded(seal(contents[0], 1, TAG, KEY), 2048)[1:]))
    made.append(("of somebody else", 2048, padded(b"hello, world" + bytes(range(1, 60)), 2048)))
    return [
        {
            "name": name,
            "payload": payload.rstrip(b"\0").hex(),
            "size": len(payload),
            **expected(payload, bits),
        }
        for name, bits, payload in made
    ]


def payload_of(tag: SimulatedTag, bits: int) -> bytes:
    """Return the payload of our record on a chip."""
    layout = format_chip(CHIPS[bits], LINK)[1]
    return tag.read()[layout.start : layout.start + layout.size]


def padded(record: bytes, bits: int = 65536) -> bytes:
    """Return a payload of a chip that begins with a record."""
    size = format_chip(CHIPS[bits], LINK)[1].size
    return record[:size].ljust(size, b"\0")


def main() -> None:
    """Write the file."""
    lines = ",\n".join(json.dumps(vector, separators=(",", ":")) for vector in vectors())
    FILE.write_text(f"[\n{lines}\n]\n")


if __name__ == "__main__":
    main()
