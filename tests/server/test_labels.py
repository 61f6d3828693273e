"""Sheets of labels: which ids, what stands on them, and a PDF of the right size."""

import re

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from robots.tags.short_id import short_id
from server.cli.main import run
from server.labels import LabelError, Sheet, numbered, sheets, tag_link

SITE = "https://usar.example:8443"


def words_of(figure):
    return [[text.get_text() for text in axes.texts] for axes in figure.axes]


def test_a_range_keeps_the_width_of_its_numbers():
    assert numbered("A-008", "A-011") == ["A-008", "A-009", "A-010", "A-011"]
    assert numbered("99", "101") == ["99", "100", "101"]
    assert numbered("door") == ["door"]


@pytest.mark.parametrize(("first", "last"), [("A1", "B2"), ("A9", "A1"), ("A", "B"), ("A0", "A99999")])
def test_what_is_no_range_is_refused(first, last):
    with pytest.raises(LabelError, match=r"range|more than"):
        numbered(first, last)


@pytest.mark.parametrize("site", ["", "https://", "ftp://usar.example", "https://usar.example/console"])
def test_what_is_no_site_is_refused(site):
    with pytest.raises(LabelError, match="no address"):
        tag_link(site, "A1")


def test_a_link_is_made_of_the_tags_own_id():
    assert tag_link("usar.example:8443", "A-017") == f"{SITE}/t/A-017"
    assert tag_link(SITE, "r2/ä 1") == f"{SITE}/t/r2%2F%C3%A4%201"


@pytest.mark.parametrize("sheet", [Sheet("a4", 8), Sheet("a4", 2), Sheet("letter", 4)])
def test_every_label_has_its_number_and_says_what_to_do_in_two_languages(sheet):
    tag_ids = numbered("A-001", "A-009")
    pages = list(sheets(tag_ids, SITE, sheet))
    assert [len(page.axes) for page in pages] == [
        len(tag_ids[k : k + sheet.labels]) for k in range(0, 9, sheet.labels)
    ]
    written = [words for page in pages for words in words_of(page)]
    for tag_id, words in zip(tag_ids, written, strict=True):
        assert {short_id(tag_id), "N", "Place / Ort", "Way out / Ausgang"} <= set(words)
        assert sum("usar.example:8443/t" in text for text in words) == 2
        assert any("Nummer eintippen" in text for text in words)


@pytest.mark.parametrize("sheet", [Sheet("a4", 8), Sheet("letter", 4)])
def test_nothing_on_a_label_leaves_it(sheet):
    figure = next(sheets(["ABCDEFGHJKMN"], "https://192.168.100.155:65535", sheet))
    renderer = FigureCanvasAgg(figure).get_renderer()
    room = figure.axes[0].get_window_extent(renderer)
    for text in figure.axes[0].texts:
        box = text.get_window_extent(renderer)
        assert room.x0 <= box.x0 < box.x1 <= room.x1, text.get_text()
        assert room.y0 <= box.y0 < box.y1 <= room.y1, text.get_text()


def test_the_command_writes_sheets_of_paper_size(tmp_path, capsys):
    out = tmp_path / "labels.pdf"
    assert run(["labels", "A-001", "A-010", "--host", SITE, "--out", str(out)]) == 0
    assert "10 labels on 2 sheets" in capsys.readouterr().err
    boxes = re.findall(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", out.read_bytes())
    assert [(round(float(w)), round(float(h))) for w, h in boxes] == [(595, 842)] * 2


def test_the_command_says_what_is_wrong(tmp_path, capsys):
    assert run(["labels", "A1", "B2", "--host", SITE]) == 1
    assert "is no range" in capsys.readouterr().err
    assert run(["labels", "A1", "--host", SITE, "--out", str(tmp_path / "none" / "x.pdf")]) == 1
    assert "No such file" in capsys.readouterr().err
