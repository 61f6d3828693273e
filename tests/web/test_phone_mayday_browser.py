"""MAYDAY from a phone: at once, again and again, in words that are true, for the right tag and mission."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Page, Route, expect

from server.benchmarks.browser import OWN_MODULE
from tests.web.field import Field

SOON_MS = 60_000
# nothing that is written into the storage ever comes to an end
SLOW_STORAGE = """
  const done = Object.getOwnPropertyDescriptor(IDBTransaction.prototype, "oncomplete");
  Object.defineProperty(IDBTransaction.prototype, "oncomplete", {
    set(then) { if (!globalThis.isSlow) done.set.call(this, then); },
  });
"""
PHOTO = """async (tag) => {
  const { add } = await OWN("/static/phone/outbox.js");
  add("photo", "drill", { tag_id: tag, text: "", picture: new Blob(["x"], { type: "image/jpeg" }) });
}""".replace("OWN", OWN_MODULE)


def hold(page: Page) -> None:
    page.get_by_role("button", name="MAYDAY").click(delay=900)


def mayday(field: Field, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Wait for a MAYDAY of whom something holds."""
    deadline = time.monotonic() + 60.0
    while True:
        with field.api as api:
            alerts = [alert for alert in api.get("/alerts").json()["alerts"] if alert["kind"] == "mayday"]
        if alerts and holds(alerts[0]):
            found: dict[str, Any] = alerts[0]
            return found
        assert time.monotonic() < deadline, alerts
        time.sleep(0.1)


def settle(field: Field) -> None:
    with field.api as api:
        api.delete("/alerts/mayday/operator").raise_for_status()
        for alert in api.get("/alerts").json()["alerts"]:
            api.post(f"/alerts/{alert['alert_id']}/acknowledge")


def test_mayday_waits_for_nothing_and_can_be_called_again(
    field: Field, context: BrowserContext, page: Page
) -> None:
    tag = field.links[0][0]
    context.add_init_script(SLOW_STORAGE)
    page.route("**/photos?*", lambda route: None)  # a photo that is being sent, and sent
    page.goto(f"{field.home}/t/{tag}")
    expect(page.get_by_role("button", name="MAYDAY: press and hold")).to_be_visible(timeout=SOON_MS)
    with page.expect_request("**/photos?*"):
        page.evaluate(PHOTO, tag)
    page.evaluate("() => { globalThis.isSlow = true; }")
    hold(page)
    first = mayday(field, lambda alert: alert["tag_id"] == tag)
    expect(page.get_by_text("MAYDAY was called at")).to_be_visible(timeout=SOON_MS)
    with field.api as api:
        api.post(f"/alerts/{first['alert_id']}/acknowledge").raise_for_status()
    expect(page.get_by_text("operator knows of your MAYDAY")).to_be_visible(timeout=SOON_MS)
    hold(page)
    mayday(field, lambda alert: alert["acknowledged_unix_s"] is None)
    settle(field)
    expect(page.get_by_role("button", name="MAYDAY: press and hold")).to_be_visible(timeout=SOON_MS)
    with field.api as api:
        told = [r for r in api.get("/reports").json()["reports"] if r["kind"] == "mayday"]
    assert len(told) == 2


def test_a_mayday_that_does_not_go_out_says_why(field: Field, page: Page) -> None:
    answers = {
        409: "MAYDAY was NOT taken. Shout, use the radio. This mission is over and takes nothing any more.",
        401: "MAYDAY is NOT sent: this phone is logged out.",
        500: re.compile(
            r"MAYDAY of \d\d:\d\d is NOT sent yet\. This phone tries again and again until it is\."
        ),
    }
    status = 0

    def refuse(route: Route) -> None:
        error = {"code": "mission_closed", "message": "Drill was closed.", "field": None}
        route.fulfill(status=status, json={"error": error})

    for status, words in answers.items():
        page.route("**/reports/*", refuse)
        page.goto(f"{field.home}/t/{field.links[0][0]}") if status == 409 else None
        hold(page)
        expect(page.get_by_role("alert").filter(has_text=words)).to_be_visible(timeout=SOON_MS)
        page.unroute("**/reports/*")
        hold(page)  # the same call, tried again
        expect(page.get_by_text("MAYDAY was called at")).to_be_visible(timeout=SOON_MS)
        settle(field)
    with field.api as api:
        assert len([e for e in api.get("/events").json()["events"] if e["kind"] == "mayday"]) >= len(answers)


def test_mayday_names_the_last_tag_where_the_phone_shows_none_and_the_mission_is_paused(
    field: Field, browser: Browser
) -> None:
    with field.api as api:
        api.post("/pause").raise_for_status()
    context = browser.new_context(viewport={"width": 390, "height": 844}, locale="de-AT")
    page = context.new_page()
    page.goto(f"{field.home}/phone")  # a phone that has never been here
    button = page.get_by_role("button", name="MAYDAY: drücken und halten")
    button.click(timeout=SOON_MS)
    expect(page.get_by_text("Länger drücken")).to_be_visible()
    page.goto(f"{field.home}/t/{field.links[0][1]}")
    expect(page.get_by_role("heading", name=f"Marke {field.links[0][1]}")).to_be_visible(timeout=SOON_MS)
    expect(button).to_be_visible(timeout=SOON_MS)
    page.evaluate("""() => {
      const last = JSON.parse(localStorage.getItem("waymark.last"));
      localStorage.setItem("waymark.last", JSON.stringify({ ...last, since_s: last.since_s - 1200 }));
    }""")
    page.goto(f"{field.home}/phone")
    expect(button).to_be_visible(timeout=SOON_MS)
    hold(page)
    found = mayday(field, lambda alert: alert["over_unix_s"] is None)
    assert found["tag_id"] == field.links[0][1]
    assert found["text"].endswith(": that tag was read 20 min ago.")
    context.close()
    settle(field)
    with field.api as api:
        api.post("/start").raise_for_status()
