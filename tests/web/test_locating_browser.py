"""Where the phone is by the nodes it hears: as the server says, heard by Web Bluetooth where that is."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page

from tests.vectors.node_places import FILE
from web.mount import mount_web

LOCATE = """async (cases) => {
  const { heardOf, sharedOf } = await import("/static/phone/hearing.js");
  const { locate } = await import("/static/phone/locating.js");
  const { fixText } = await import("/static/phone/fix_words.js");
  return cases.map(({ radio, tags, signals, since, plan }) => {
    const ground = plan && { classes: Uint8Array.from(plan.rows.join("")), width: plan.rows[0].length,
      height: plan.rows.length, origin_m: plan.origin_m, resolution_m: plan.resolution_m };
    const { heard, unknown } = heardOf({ radio, tags }, new Map(Object.entries(signals)));
    const found = locate(heard, sharedOf(radio), since, ground);
    return found ? { ...found, text: fixText(found, tags, unknown, null) } : {};
  });
}"""


@pytest.fixture
def page(browser: Browser, serve: Any) -> Iterator[Page]:
    app = FastAPI()
    mount_web(app)
    context = browser.new_context(locale="en-GB")
    page = context.new_page()
    page.goto(f"http://{serve(app)}/static/logo.svg")  # any page of the server's
    yield page
    context.close()


def test_a_phone_locates_itself_as_the_server_would(page: Page) -> None:
    cases = json.loads(FILE.read_text())
    asked = [{name: value for name, value in case.items() if name != "expected"} for case in cases]
    for case, found in zip(cases, page.evaluate(LOCATE, asked), strict=True):
        expected = case["expected"]
        assert found.keys() == expected.keys()
        if not expected:
            continue
        assert (found["text"], found["fits"]) == (expected["text"], expected["fits"])
        assert found["left_out"] == expected["left_out"]
        assert (found["ring"] is None) == (expected["ring"] is None)
        if found["ring"]:
            assert found["ring"].pop("node_id") == expected["ring"].pop("node_id")
            assert found["ring"] == pytest.approx(expected["ring"], rel=1e-6)
        assert len(found["places"]) == len(expected["places"])
        for ours, theirs in zip(found["places"], expected["places"], strict=True):
            assert ours == pytest.approx(theirs, rel=1e-6, abs=1e-6)
