"""Short ids by the vectors that the phone's script is held to as well."""

import json
from pathlib import Path

import pytest

from robots.tags.short_id import short_id, understood

VECTORS = json.loads((Path(__file__).parents[2] / "vectors" / "short_ids.json").read_text())


@pytest.mark.parametrize(("tag_id", "written"), VECTORS["short_ids"].items())
def test_what_is_printed_for_a_tag(tag_id, written):
    assert short_id(tag_id) == written


@pytest.mark.parametrize("row", VECTORS["typed"], ids=lambda row: row["typed"] or "nothing")
def test_what_is_typed(row):
    found = understood(row["typed"], VECTORS["tags"])
    assert (list(found.tag_ids), found.trouble) == (row["tag_ids"], row["trouble"])
