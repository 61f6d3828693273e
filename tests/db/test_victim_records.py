"""START by its steps (adult): whatever the answers, and whatever of them is missing."""

from dataclasses import asdict, replace

from hypothesis import given
from hypothesis import strategies as st

from db.victim_records import SaidRecord, StartRecord

answers = st.none() | st.booleans()
starts = st.builds(StartRecord, answers, st.none() | st.integers(0, 60), answers, answers, answers)

whole = st.builds(StartRecord, *[st.booleans(), st.integers(0, 60), *[st.booleans()] * 3])


def as_printed(start: StartRecord) -> str:
    """The category by the flow chart, once all questions are answered."""
    if start.walks:
        return "minor"
    if start.breaths_per_min == 0:
        return "immediate" if start.breathes_after_airway else "deceased"
    if start.breaths_per_min > 30 or not start.pulse or not start.obeys:
        return "immediate"
    return "delayed"


@given(whole)
def test_all_answers_give_the_category_of_the_flow_chart(start):
    assert start.triage == as_printed(start)


@given(starts, whole)
def test_answers_that_come_later_never_change_a_category(start, rest):
    """What is decided is decided by answers that are there, so filling the others in changes nothing."""
    filled = replace(rest, **{name: value for name, value in asdict(start).items() if value is not None})
    assert start.triage in ("unknown", filled.triage)


@given(starts)
def test_nobody_is_called_dead_without_a_person_who_opened_the_airway(start):
    if start.triage == "deceased":
        assert (start.walks, start.breaths_per_min, start.breathes_after_airway) == (False, 0, False)


@given(st.builds(SaidRecord, start=starts, place_m=st.none() | st.tuples(st.floats(-9, 9), st.floats(-9, 9))))
def test_what_was_said_survives_being_stored(said):
    assert SaidRecord.of(said.value()) == said
