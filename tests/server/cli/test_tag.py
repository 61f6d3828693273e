"""`waymark tag`, run as a user would."""

import json

import numpy as np
import pytest

from robots.tags.chip import chip_of, format_chip
from robots.tags.describe import describe, understand
from robots.tags.map_memory import TagBelief, WriterMap
from robots.tags.marks import Note, Notes, goal_mark, victim_mark
from robots.tags.memory import CLOSED, OPEN, TagMemory, TagMemoryError
from server.cli.main import run

KEY = "00ff17"
LINK = "https://w.example/t/A4"
MEMORY = TagMemory(
    np.zeros((5, 5), np.uint8),
    (WriterMap("r1", 7, (TagBelief("B", 1.0, 2.0, 0.25, 0.0, 0.5),)),),
    (victim_mark("v1", 0.8, 720.0, 3.0, -1.5),),
    Notes((Note(2, "Kim", "gas, turn back"),)),
    (goal_mark("r1", 3, 0, -4.0, 2.5),),
    np.array([[0, 0, 0], [0, 2, 1], [0, 0, 0]], np.uint8),
)
MEMORY.cells[3, 1] = OPEN  # one cell to the north, one to the east
MEMORY.cells[2, 4] = CLOSED  # two cells to the west

DRAWN = [".....", "...o.", "#....", ".....", "....."]


def make(tmp_path, capsys, memory=MEMORY, *options):
    source, chip = tmp_path / "memory.json", tmp_path / "chip.bin"
    source.write_text(json.dumps({"memory": describe(memory)}))
    arguments = ["tag", "encode", str(source), "--id", "A4", "--link", LINK, "--out", str(chip), "--key", KEY]
    assert run([*arguments, "--json", *options]) == 0
    return chip, json.loads(capsys.readouterr().out)


def decoded(chip, capsys, *options):
    assert run(["tag", "decode", str(chip), "--id", "A4", "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("bits", [7104, 8192, 65536])
def test_what_was_encoded_is_decoded(tmp_path, capsys, bits):
    chip, said = make(tmp_path, capsys, MEMORY, "--tag-bits", str(bits), "--revision", "9")
    assert said["complete"]
    assert chip.stat().st_size * 8 == bits
    result = decoded(chip, capsys, "--key", KEY)
    assert {k: result[k] for k in ("link", "records", "revision", "trusted")} == {
        "link": LINK,
        "records": 1,
        "revision": 9,
        "trusted": True,
    }
    assert result["memory"]["window"] == DRAWN
    assert understand(result["memory"]) == MEMORY


def test_hexadecimal_digits_do_as_well(tmp_path, capsys):
    chip, _ = make(tmp_path, capsys)
    digits = tmp_path / "chip.txt"
    digits.write_text(chip.read_bytes().hex(" ") + "\n")
    assert decoded(digits, capsys) == decoded(chip, capsys)


def test_on_a_small_chip_it_is_said_that_something_went(tmp_path, capsys):
    chip, said = make(tmp_path, capsys, MEMORY, "--tag-bits", "512")
    assert not said["complete"]
    assert said["content_bytes"] <= said["room_bytes"]
    kept = decoded(chip, capsys, "--key", KEY)["memory"]
    assert (kept["window"], kept["maps"], kept["notes"], kept["victims"]) == (DRAWN, [], [], [])


def test_a_strangers_tag_is_shown_and_not_believed(tmp_path, capsys):
    chip, _ = make(tmp_path, capsys)
    assert not decoded(chip, capsys)["trusted"]
    assert run(["tag", "show", str(chip), "--id", "A4"]) == 0
    assert "do not believe it" in capsys.readouterr().out


def test_it_draws_north_up(tmp_path, capsys):
    chip, _ = make(tmp_path, capsys)
    assert run(["tag", "show", str(chip), "--id", "A4", "--key", KEY]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:5] == [*DRAWN[:2], "#.T..", *DRAWN[3:]]
    assert said[6:] == [
        "Victim ccb5: 3.0 m plan north and 1.5 m plan east of the tag, 80% sure, seen at minute 12.",
        "Kim writes: gas, turn back",
        "Robot 09b1 passed here 3 times,"
        " last on its way to a place 4.0 m plan south and 2.5 m plan west of the tag.",
        "Robots drove through 2 cells of 0.4 m round it.",
    ]
    assert run(["tag", "decode", str(chip), "--id", "A4", "--key", KEY]) == 0
    assert "covered_m2" in capsys.readouterr().out


def test_a_fresh_tag_says_nothing_yet(tmp_path, capsys):
    (tmp_path / "fresh.bin").write_bytes(format_chip(chip_of(2048), LINK)[0])
    result = decoded(tmp_path / "fresh.bin", capsys)
    assert (result["records"], result["revision"], result["memory"]["window"]) == (0, None, ["."])


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "no chip has 0 bits"),
        (bytes(256), "end too early"),
        (b"x" * 3, "no chip has 24"),
        (None, "No such"),
    ],
)
def test_what_is_no_tag_is_refused_in_a_sentence(tmp_path, capsys, data, message):
    path = tmp_path / "x.bin"
    if data is not None:
        path.write_bytes(data)
    assert run(["tag", "decode", str(path), "--id", "A4"]) == 1
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([], "an object with window, maps, victims"),
        ({"cells": []}, "an object with window, maps, victims"),
        ({"window": "..."}, "list of texts"),
        ({"window": ["..", ".."]}, "odd side"),
        ({"window": ["..."]}, "odd side"),
        ({"window": ["x"]}, "one of . o #"),
        ({"maps": [{"robot_id": "r1"}]}, "maps: each has robot_id"),
        ({"maps": 3}, "maps: each has robot_id"),
    ],
)
def test_memories_that_make_no_sense_are_refused(value, message):
    with pytest.raises(TagMemoryError, match=message):
        understand(value)


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--key", "xyz", "at most 64 hexadecimal digits"),
        ("--key", "00" * 33, "at most 64 hexadecimal digits"),
        ("--tag-bits", "100", "no chip has 100 bits"),
        ("--link", "https://" + "a" * 300, "make it shorter"),
    ],
)
def test_options_that_make_no_sense_are_named(tmp_path, capsys, option, value, message):
    source = tmp_path / "memory.json"
    source.write_text(json.dumps({"memory": {}}))
    out = str(tmp_path / "x")
    assert run(["tag", "encode", str(source), "--id", "A", "--link", LINK, "--out", out, option, value]) == 1
    assert message in capsys.readouterr().err
