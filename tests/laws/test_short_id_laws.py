"""A tag's short id: what people write differently is the same, and what they mistype is noticed."""

from hypothesis import given
from hypothesis import strategies as st

from robots.tags.short_id import ALPHABET, check_character, folded, short_id, understood

letters = st.sampled_from(ALPHABET)
plains = st.text(letters, min_size=1, max_size=12)


def whole(plain):
    return plain + check_character(plain)


def fits(word):
    return check_character(word[:-1]) == word[-1]


@given(plains, st.data())
def test_one_wrong_character_is_found(plain, data):
    word = whole(plain)
    at = data.draw(st.integers(0, len(plain)))
    wrong = data.draw(letters.filter(lambda letter: letter != word[at]))
    assert not fits(word[:at] + wrong + word[at + 1 :])


@given(plains, st.data())
def test_two_swapped_neighbours_are_found(plain, data):
    word = whole(plain)
    at = data.draw(st.integers(0, len(plain) - 1))
    swapped = word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    assert swapped == word or not fits(swapped)


@given(plains)
def test_a_nought_in_front_is_found(plain):
    assert not fits("0" + whole(plain))


@given(plains, st.data())
def test_case_gaps_and_look_alikes_are_forgiven(plain, data):
    written = []
    for letter in short_id(plain):
        alike = {"0": "0oO", "1": "1iIlL", "V": "vVuU", "-": " -_"}.get(letter, letter + letter.lower())
        written.append(data.draw(st.sampled_from(alike)))
        written.append(data.draw(st.sampled_from(["", " ", "-"])))
    assert folded("".join(written)) == whole(plain)
    assert understood("".join(written), [plain]).tag_ids == (plain,)


@given(st.text(max_size=30), st.lists(st.text(min_size=1, max_size=8), max_size=8))
def test_anything_may_be_typed(typed, tag_ids):
    found = understood(typed, tag_ids)
    assert set(found.tag_ids) <= set(tag_ids)
    assert bool(found.tag_ids) == (found.trouble == "")


@given(st.lists(st.text(min_size=1, max_size=8), min_size=1, max_size=8))
def test_a_robots_own_name_always_leads_to_its_tag(tag_ids):
    assert all(
        tag_id in understood(tag_id, tag_ids).tag_ids for tag_id in tag_ids if tag_id.strip() == tag_id
    )
