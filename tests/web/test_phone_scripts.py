"""Scripts of the phone alone in a browser: on the vectors that Python is held to, and what they keep."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page

from web.mount import mount_web

VECTORS = Path(__file__).parents[1] / "vectors"
KEPT = """async () => {
  const { keepSent, sentBeyond } = await import("/static/phone/sent.js");
  const ids = (has, later_s, mission_id = "m") => {
    const notes = has.map((annotation_id) => ({ annotation_id }));
    return sentBeyond({ mission_id, notes }, 1000 + later_s).map(({ id }) => id);
  };
  const tell = (id, kind = "note", mission_id = "m") => keepSent({ id, kind, mission_id, body: {} }, 1000);
  tell("a"); tell("b"); tell("b"); tell("c", "note", "other"); tell("d", "victim");
  const first = [ids([], -9), ids([], 0), ids(["a"], 0)];
  return [...first, ids([], 0), ids([], 0.001), ids([], 0), ids([], 0, "other")];
}"""


@pytest.fixture
def page(browser: Browser, serve: Any) -> Iterator[Page]:
    """A page from which the scripts can be imported."""
    app = FastAPI()
    mount_web(app)
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"http://{serve(app)}/static/logo.svg")
    yield page
    context.close()


def test_short_ids_are_those_of_the_server(page: Page) -> None:
    vectors = json.loads((VECTORS / "short_ids.json").read_text())
    made = page.evaluate(
        """async ({short_ids, tags, typed}) => {
          const { shortId, understood } = await import("/static/phone/short_id.js");
          const written = Object.keys(short_ids).map((id) => [id, shortId(id)]);
          return [Object.fromEntries(written), typed.map((row) => understood(row.typed, tags))];
        }""",
        vectors,
    )
    assert made[0] == vectors["short_ids"]
    assert made[1] == [{"tagIds": row["tag_ids"], "trouble": row["trouble"]} for row in vectors["typed"]]


def test_what_was_taken_off_before_the_phone_had_it_goes(page: Page) -> None:
    assert page.evaluate(KEPT) == [["a", "b"], ["a", "b"], ["b"], ["b"], [], [], ["c"]]
