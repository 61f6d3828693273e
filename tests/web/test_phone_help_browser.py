"""EVACUATE and MAYDAY are in view on every page of the phone, however far it was scrolled."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.web.field import Field

SOON_MS = 60_000
FAR_DOWN = "scrollTo({ top: document.documentElement.scrollHeight, behavior: 'instant' })"


@pytest.mark.parametrize("at_tag", [False, True])
def test_evacuate_stays_in_view_and_is_heard_with_one_tap(field: Field, page: Page, at_tag: bool) -> None:
    page.set_viewport_size({"width": 390, "height": 500})
    page.goto(f"{field.home}/t/{field.links[0][0]}" if at_tag else f"{field.home}/phone")
    mayday = page.get_by_role("button", name="MAYDAY")
    expect(mayday).to_be_in_viewport(ratio=1, timeout=SOON_MS)
    page.evaluate(FAR_DOWN)
    expect(mayday).to_be_in_viewport(ratio=1)
    with field.api as api:
        api.post("/evacuation").raise_for_status()
        alarm = page.get_by_role("alert").filter(has_text=re.compile("EVACUATE"))
        expect(alarm).to_be_in_viewport(ratio=1, timeout=SOON_MS)  # and spoken, as a role alert that appears
        page.evaluate(FAR_DOWN)
        assert page.evaluate("scrollY") > 0
        expect(alarm).to_be_in_viewport(ratio=1)
        heard = alarm.get_by_role("button", name="I have heard it")
        assert (heard.bounding_box() or {"height": 0})["height"] >= 64
        heard.click(timeout=SOON_MS)
        expect(heard).to_have_count(0)
        expect(alarm).to_be_in_viewport(ratio=1)
        expect(alarm).not_to_contain_text("as soon as there is signal", timeout=SOON_MS)
        assert [who["name"] for who in api.get("/evacuation").json()["acknowledged"]] == ["operator"]
        api.delete("/evacuation").raise_for_status()
        expect(alarm).to_have_count(0, timeout=SOON_MS)
