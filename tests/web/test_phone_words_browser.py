"""What the phone's page says when it is looked at hours later, and of a call that does not get through."""

from __future__ import annotations

import re

from playwright.sync_api import BrowserContext, Page, Route, expect

from tests.web.axe import SMALL
from tests.web.field import Field

SOON_MS = 60_000
LATER = """
  const now = Date.now;
  globalThis.later_ms = 0;
  Date.now = () => now() + globalThis.later_ms;
"""
SHOWN = """([hours, event]) => {
  globalThis.later_ms = hours * 3_600_000;
  (event === "pageshow" ? globalThis : document).dispatchEvent(new Event(event, { bubbles: true }));
  return document.querySelector(".where").textContent;
}"""
WATCH = """() => {
  globalThis.said = [];
  const look = () => {
    const text = document.querySelector("#foot .alarm")?.textContent ?? "";
    if (text !== said.at(-1)) said.push(text);
  };
  new MutationObserver(look).observe(document.getElementById("foot"),
    { childList: true, subtree: true, characterData: true });
}"""


def test_hours_later_it_says_when_one_was_there_and_goes_on(
    field: Field, context: BrowserContext, page: Page
) -> None:
    tag = field.links[0][0]
    context.add_init_script(LATER)
    page.goto(f"{field.home}/t/{tag}")
    expect(page.get_by_role("button", name="Leave word here")).to_be_visible(timeout=SOON_MS)
    shown = {event: page.evaluate(SHOWN, [0, event]) for event in ("pageshow", "visibilitychange")}
    assert all(text.startswith(f"You are at tag {tag}") for text in shown.values())
    rest = shown["pageshow"].split(". ", 1)[1]
    for hours, event, when in (
        (0.5, "pageshow", "30 minutes ago"),
        (3, "visibilitychange", "3 hours ago"),
        (50, "pageshow", "2 days ago"),
        (-2, "visibilitychange", "some time ago"),  # its clock was set
    ):
        text = page.evaluate(SHOWN, [hours, event])
        assert text.startswith(f"You were at tag {tag} {when}. Touch a tag."), text
        assert text.endswith(rest)
    page.evaluate(SHOWN, [3, "pageshow"])
    page.get_by_role("button", name="Deutsch").click()
    expect(page.locator(".where")).to_contain_text(f"Sie waren vor 3 Stunden an Marke {tag}. Berühren Sie")
    page.get_by_role("button", name="English").click()
    assert page.evaluate(SMALL) == {"low": [], "small": [], "wide": 0}
    page.get_by_role("button", name=f"Victim {field.victim}").click()  # it leads all the same
    expect(page.locator(".go .number")).to_be_visible()
    page.get_by_role("button", name="Stop leading me").click()
    page.get_by_label("The number on the tag").fill(tag)  # they are there once more
    page.get_by_role("button", name="Where am I?").click()
    expect(page.locator(".where")).to_contain_text(f"You are at tag {tag}")


def test_a_mayday_that_does_not_get_through_says_one_thing_until_it_does(field: Field, page: Page) -> None:
    """Its own requests fail while others are answered: the server is in reach and out of it in turns."""
    tries = 0

    def busy(route: Route) -> None:
        nonlocal tries
        tries += 1
        route.fulfill(status=503, json={"error": {"code": "busy", "message": "Not now.", "field": None}})

    page.goto(f"{field.home}/t/{field.links[0][0]}")
    expect(page.get_by_role("button", name="MAYDAY")).to_be_visible(timeout=SOON_MS)
    page.route("**/reports/*", busy)
    page.evaluate(WATCH)
    page.get_by_role("button", name="MAYDAY").click(delay=900)
    looks = 0
    while tries < 5 or looks < 2:
        with page.expect_response("**/evacuation", timeout=SOON_MS):
            looks += 1
    said = [text for text in page.evaluate("said") if text]
    assert said[:-1] in ([], ["MAYDAY is being sent."])
    not_yet = r"MAYDAY of \d\d:\d\d is NOT sent yet\. This phone tries again and again until it is\."
    assert re.match(not_yet, said[-1])
    page.unroute("**/reports/*")
    expect(page.get_by_text("MAYDAY was called at")).to_be_visible(timeout=SOON_MS)
    with field.api as api:
        api.delete("/alerts/mayday/operator").raise_for_status()
