"""A word that a phone left in a tag: a robot brings it home, and its writer's report does not double it."""

import base64
import itertools
import struct
import time
from binascii import crc_hqx
from functools import partial
from uuid import uuid4

import pytest

from robots.tags.content import encode_memory
from robots.tags.marks import Note, Notes
from robots.tags.memory import TagMemory
from robots.tags.record import seal
from server.mission.chip_notes import chip_note_id

KEY = "00ff17"
SEALED = seal(encode_memory(TagMemory.empty()), 0, "A4", bytes.fromhex(KEY))


def unsealed(*texts, author="Kim"):
    notes = tuple(Note(len(texts) - k, author, text) for k, text in enumerate(texts))
    empty = TagMemory.empty()
    content = encode_memory(TagMemory(empty.cells, (), (), Notes(notes)))
    head, rest = struct.pack(">BHH", 3, 0, len(content)), content + bytes(8)
    return head + struct.pack(">H", crc_hqx(head + rest, 0xFFFF)) + rest


@pytest.fixture
def line(control):
    line = control.open(tag_key=KEY)
    assert line.register(**line.words).status_code == 201
    numbers = itertools.count()

    def read_tag(memory):
        seq = next(numbers)
        sighting = {"tag_id": "A4", "memory": base64.b64encode(memory).decode()}
        line.send([{"seq": seq, "stamp_s": seq * 0.1, "tag_sightings": [sighting]}])

    line.read_tag = read_tag
    return line


def report(line, text, note="hazard", made_by="Kim", report_id=None, is_carried=False):
    now = time.time()
    body = {"kind": "note", "note": note, "text": text, "tag_id": "A4", "made_by": made_by}
    body["is_carried"] = is_carried
    said = body | {"phone_unix_s": now, "sent_phone_unix_s": now}
    assert line.call("PUT", f"/reports/{report_id or uuid4()}", said).status_code == 201


def on_map(line):
    found = line.get("/annotations")["annotations"]
    return sorted((a["kind"], a["text"], a["tag_id"], a["by"].partition(" (")[0]) for a in found)


def test_a_robot_brings_home_what_a_phone_left_in_a_tag(line):
    memory = SEALED + unsealed("hazard: gas <b>", "two doors")
    line.read_tag(memory)
    line.read_tag(memory)
    assert on_map(line) == [("hazard", "gas <b>", "A4", "Kim"), ("note", "two doors", "A4", "Kim")]
    (by,) = {a["by"] for a in line.get("/annotations")["annotations"]}
    assert "without seal" in by
    assert line.events("tag_unreadable") == []  # what the robots sealed counts as ever
    line.read_tag(SEALED + unsealed("searched: all clear", "hazard: gas <b>", "two doors"))
    assert ("searched", "all clear", "A4", "Kim") in on_map(line)
    assert len(on_map(line)) == 3


@pytest.mark.parametrize("chip_first", [True, False])
def test_the_writers_own_report_and_the_chips_note_count_once(line, chip_first):
    long = "gas " * 60  # more than a tag takes
    in_tag = f"hazard: {long}".encode()[:120].decode()
    steps = [lambda: line.read_tag(SEALED + unsealed(in_tag)), lambda: report(line, long.strip() + " end")]
    for step in steps if chip_first else reversed(steps):
        step()
    assert on_map(line) == [("hazard", long.strip() + " end", "A4", "Kim")]
    report(line, "gas", made_by="Ann")  # another one's word is another one
    assert len(on_map(line)) == 2


def test_a_chip_of_a_stranger_cannot_fill_the_map(line):
    line.read_tag(SEALED + unsealed(*(f"note: {k}" for k in range(60))))
    assert len(on_map(line)) == 50


@pytest.mark.parametrize("order", [*itertools.permutations(["robot", "reader", "writer"])])
def test_robot_reader_and_writer_bring_it_in_any_order_and_it_counts_once(line, order):
    """Another phone that read the tag carries the word on, by an id that anyone makes the same.

    The writer's phone may not have known who they are as it wrote into the tag; another may bring its report.
    """
    shown = []
    for author, is_carried in (("Kim", False), ("Kim", True), ("?", False), ("?", True)):
        text, word = (f"{start}gas é {author} {is_carried}" for start in ("", "hazard: "))
        copy = chip_note_id("A4", author, word)
        ways = {
            "robot": partial(line.read_tag, SEALED + unsealed(word, author=author)),
            "reader": partial(report, line, text, made_by=author, report_id=copy, is_carried=is_carried),
            "writer": partial(report, line, text, is_carried=is_carried),
        }
        for who in order:
            ways[who]()
            known = [note for note in on_map(line) if note not in shown]
            assert [note[:3] for note in known] == [("hazard", text, "A4")], (author, is_carried, who)
        assert known[0][3] in ("Kim", author)
        shown += known


def test_a_forged_memory_is_an_alert_and_a_phones_word_is_none(line):
    line.read_tag(unsealed("note: here"))
    assert line.get("/alerts")["alerts"] == []
    forged = seal(encode_memory(TagMemory.empty()), 9, "A4", b"another key")
    copied = seal(encode_memory(TagMemory.empty()), 9, "A5", bytes.fromhex(KEY))
    for memory in (forged, copied):
        line.read_tag(memory)
        (alert,) = line.get("/alerts")["alerts"]
        assert (alert["kind"], alert["tag_id"], alert["severity"]) == ("tag", "A4", "warning")
        assert "Tag A4 may be forged or a copy" in alert["text"]


@pytest.mark.parametrize("chip_first", [True, False])
def test_a_victim_that_was_reported_is_no_note_besides(line, chip_first):
    line.read_tag(SEALED)
    now = time.time()
    body = {"kind": "victim", "tag_id": "A4", "live": 2, "dead": 0, "text": "under the stairs"}
    body |= {"made_by": "Kim", "phone_unix_s": now, "sent_phone_unix_s": now}
    steps = [
        lambda: line.read_tag(SEALED + unsealed("victim: L-2 D-0 under the stairs")),
        lambda: line.call("PUT", f"/reports/{uuid4()}", body),
    ]
    for step in steps if chip_first else reversed(steps):
        step()
    whole = ("victim", "2 live, 0 dead, START: unknown. under the stairs", "A4", "Kim")
    assert on_map(line) == [whole]  # a victim, once its tag has a place
    carried = chip_note_id("A4", "Kim", "victim: L-2 D-0 under the stairs")  # by another phone, too
    report(line, "L-2 D-0 under the stairs", note="victim", report_id=carried)
    assert on_map(line) == [whole]
    line.read_tag(SEALED + unsealed("victim: L-1 D-0 in the bath", "exit: gate"))
    others = [("exit", "gate", "A4", "Kim"), ("victim", "L-1 D-0 in the bath", "A4", "Kim")]
    assert on_map(line) == sorted([whole, *others])
