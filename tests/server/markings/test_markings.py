"""What is sprayed says what is known, and nothing else, whatever people have said."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from db.victim_records import SaidRecord
from db.worksites import ClearanceRecord, RatingRecord, VisitRecord, WorksiteRecord, goes_on
from server.markings.shapes import EM, lines_of, size_that_fits
from server.markings.victims import victim_markings, victim_words
from server.markings.worksites import inside, worksite_markings
from tests.server.markings.states import sectors, victims

COUNT = st.none() | st.integers(0, 4)
X, BAR = "M16 12 84 84M84 12 16 84", "M14 46H86"


def texts(marking):
    return [shape["text"] for shape in marking.shapes if "text" in shape]


def paths(marking):
    return [shape["path"] for shape in marking.shapes if "path" in shape]


@given(st.lists(st.tuples(st.sampled_from(["live", "dead"]), COUNT), max_size=15))
def test_a_count_that_changed_is_crossed_out_and_the_new_one_below(said):
    """A wall is painted on and nothing erased; only what somebody takes back was never there."""
    record, wall = SaidRecord(), {"live": [], "dead": []}
    for name, count in said:
        words = {name: count}
        if count is None:
            wall[name] = []
        elif count != getattr(record, name) and count:
            wall[name].append(count)
        record = SaidRecord(**{**record.value(), "start": record.start, **words, **record.crossed_out(words)})
    for name in ("live", "dead"):
        standing = [count for count in [getattr(record, name)] if count]
        assert [*getattr(record, f"{name}_before"), *standing] == wall[name]
    assert SaidRecord.of(record.value()) == record


@given(victims())
def test_the_marking_of_a_victim_is_never_wrong(victim):
    drawn = victim_markings(victim)
    if victim["status"] == "dismissed":
        assert drawn == []
        return
    insarag, fema, *by_card = drawn
    live, dead = victim["live"] or 0, victim["dead"] or 0
    strokes = len(paths(insarag)) - 1  # beside the V
    standing = [text for text, n in ((f"L-{live}", live), (f"D-{dead}", dead)) if n]
    assert len(texts(insarag)) - strokes == len(standing)  # all other counts are crossed out
    assert set(standing) <= set(texts(insarag))
    assert not {"L-0", "D-0"} & set(texts(insarag))
    # FEMA: in a circle where living were found, a bar where dead were, an X only where nobody is left
    assert any("ring" in shape for shape in fema.shapes) == bool(live or victim["live_before"])
    assert (BAR in paths(fema)) == bool(dead or victim["dead_before"])
    found = live or dead or victim["live_before"] or victim["dead_before"]
    is_empty = bool(found or victim["status"] == "extricated") and not live and not dead
    assert (X in paths(fema)) == is_empty
    assert len(by_card) == is_empty
    assert ("still there" in victim_words(victim)) == bool(live or dead)
    for marking in drawn:
        assert_within(marking)


@given(sectors())
def test_the_marking_of_a_worksite_is_never_wrong(told):
    sector, there = told
    worksite = sector["worksite"]
    drawn = worksite_markings(sector, there)
    if worksite is None:
        assert drawn == []
        return
    insarag, visits = drawn[0], worksite["visits"]
    done = [visit for visit in visits if visit["level"] and visit["is_finished"]]
    lines = [text for text in texts(insarag) if " ASR" in text]
    assert len(lines) == len(done)
    for line, visit in zip(lines, done, strict=True):
        assert f" ASR{visit['level']} " in line
    is_new = worksite["worksite_id"][1] != "-"
    assert insarag.name == f"INSARAG {'2027' if is_new else '2020'}, worksite"
    assert worksite["worksite_id"] in texts(insarag)
    below = [shape["text"] for shape in insarag.shapes if "text" in shape and shape["size"] == 52]
    assert below == ([worksite["triage"]] if worksite["triage"] else [])
    assert len(paths(insarag)) == 1 + worksite["is_complete"]  # the line through it: no more work
    ratings, clearances = worksite.get("ratings", ()), worksite.get("clearances", ())
    assert len(drawn) == 1 + bool(visits) + bool(ratings) + len(clearances)
    if ratings:
        check_structure(drawn[1 + bool(visits)], ratings[-1])
    for diamond, cleared in zip(drawn[len(drawn) - len(clearances) :], clearances, strict=True):
        assert texts(diamond)[0] == {"clear": "C", "deceased": "D"}[cleared["found"]]
    if visits:
        check_search(drawn[1], visits, inside(sector, there))
    for marking in drawn:
        assert_within(marking)


def check_structure(box, rating):
    """An empty box for low risk, one stroke through it for moderate, two for high; an arrow beside it."""
    square, *strokes = paths(box)
    assert square.endswith("Z")
    crossing = [path for path in strokes if len(path.split()) == 4]
    assert len(crossing) == {"low": 0, "moderate": 1, "high": 2}[rating["risk"]]
    assert len(strokes) - len(crossing) == (rating["entry"] is not None)
    assert texts(box)[-1] == rating["team"]
    assert box.words.startswith(f"{rating['team']} rates the structure a {rating['risk']} risk")


def check_search(fema, visits, there):
    is_inside = any(visit["left_unix_s"] is None for visit in visits)
    is_finished = visits[-1]["is_finished"]
    assert ("M200 60 100 160" in paths(fema)) == (not is_inside and is_finished)
    assert any("ring" in shape for shape in fema.shapes) == (not is_inside and not is_finished)
    has_zero = "0" in [s["text"] for s in fema.shapes if "text" in s and s["at"] == [150, 190]]
    assert has_zero == (not is_inside and there.live == there.dead == there.uncounted == 0)


def assert_within(marking):
    for shape in marking.shapes:
        if "text" in shape:
            x, y = shape["at"]
            wide = EM * shape["size"] * len(shape["text"])
            left = x - {"middle": wide / 2, "end": wide, "start": 0}[shape["anchor"]]
            assert left >= -0.5
            assert left + wide <= marking.width + 0.5
            assert 0.7 * shape["size"] - 2 <= y <= marking.height


@pytest.mark.parametrize(("name", "team"), [("C-5", "AUS-01"), ("AUS01-0102", "AUS01")])
def test_editions_of_insarag_differ_in_ids_and_the_line_of_completion(name, team):
    visit = {"team": "AUS01", "level": 3, "entered_unix_s": 1e9, "left_unix_s": 1e9 + 60, "is_finished": True}
    worksite = {
        "worksite_id": name, "hazards": "gas", "triage": "B", "is_complete": True,
        "visits": [{**visit, "parts": ""}],
    }  # fmt: skip
    sector = {"area_m": [[0, 0], [1, 0], [0, 1]], "worksite": worksite}
    insarag = worksite_markings(sector, [])[0]
    (line,) = [text for text in texts(insarag) if " ASR3 " in text]
    assert line.split()[0] == team
    (across,) = [path for path in paths(insarag) if path.startswith("M8 ")]
    height = int(across.split()[1].split("H")[0])
    ys = {shape["text"]: shape["at"][1] for shape in insarag.shapes if "text" in shape}
    (box,) = [path for path in paths(insarag) if path.endswith("Z")]
    top, bottom = int(box.split()[1].split("H")[0]), int(box.split("V")[1].split("H")[0])
    if name == "C-5":
        assert 2 * height == top + bottom  # through the marking
    else:
        assert ys[name] < height < ys[line] - 14  # below the id, above the lines


@given(st.text(max_size=60), st.integers(1, 30))
def test_lines_hold_every_word_once(text, most):
    lines = lines_of(text, most)
    assert " ".join(lines).split() == text.split()
    assert all(len(line) <= most or " " not in line for line in lines)


@given(st.text(min_size=1, max_size=60), st.integers(1, 90), st.integers(10, 300))
def test_letters_fit_or_are_as_small_as_can_be(text, size, room):
    found = size_that_fits(text, size, room)
    assert 1 <= found <= size
    assert found == 1 or EM * found * len(text) <= room


def test_visits_to_a_worksite_are_never_erased():
    went = VisitRecord("AUS01", 3, 10.0)
    left = VisitRecord("AUS01", 3, 10.0, 20.0, True, "Floor 1")
    other = VisitRecord("USA02", None, 15.0)

    def site(*visits):
        return WorksiteRecord("C-5", "", None, False, visits)

    assert goes_on(None, site(went))
    assert goes_on(site(went), site(left, other))
    assert goes_on(site(), None)
    assert not goes_on(site(went), site(other))
    assert not goes_on(site(went, other), site(went))
    assert not goes_on(site(left), site(went))
    assert not goes_on(site(went), None)


def test_what_is_rated_or_cleared_is_never_erased():
    low, high = RatingRecord("AUS01", "low", None, 10.0), RatingRecord("AUS01", "high", "left", 20.0)
    dead, clear = ClearanceRecord("AUS01", "deceased", 30.0), ClearanceRecord("AUS01", "clear", 40.0)
    bare = WorksiteRecord("C-5", "", None, False, ())
    for name, (first, second) in (("ratings", (low, high)), ("clearances", (dead, clear))):
        one, two = replace(bare, **{name: (first,)}), replace(bare, **{name: (first, second)})
        assert goes_on(bare, one)
        assert goes_on(one, two)
        assert not goes_on(two, one)
        assert not goes_on(one, replace(bare, **{name: (second,)}))
        assert not goes_on(one, None)
