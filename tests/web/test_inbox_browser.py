"""The inbox of victims in a browser: unseen first, merged, split, moved, judged by keys, taken back."""

from __future__ import annotations

import time
from typing import Any
from uuid import uuid4

import pytest
from playwright.sync_api import Browser, expect

from server.app import create_app
from server.settings import Settings
from tests.web.driven import drive

pytestmark = pytest.mark.browser
SOON_MS = 60_000


def test_victims_are_sorted_judged_merged_split_and_moved(
    browser: Browser, serve: Any, tmp_path: Any, robot_log: Any
) -> None:
    home = f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off', reply_s=60.0)))}"
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    seen = drive(page.request, home, robot_log)
    api, robots = f"{home}/api/v1/missions/drill", seen["victim"]
    now = time.time()
    report = {"kind": "victim", "tag_id": seen["tag"], "live": 2, "dead": 1}
    clocks = {"phone_unix_s": now, "offset_s": 0.0, "sent_phone_unix_s": now}
    sent = page.request.put(f"{api}/reports/{uuid4()}", data={**report, **clocks}, headers={"Origin": home})
    assert sent.ok, sent.text()
    (person,) = {each["victim_id"] for each in page.request.get(f"{api}/victims").json()["victims"]} - {
        robots
    }

    page.goto(home)
    cards = page.locator(".victim-card")
    expect(cards).to_have_count(2, timeout=SOON_MS)
    expect(cards.first).to_have_attribute("data-victim", robots)  # nobody has looked at it yet
    expect(cards.first.locator(".confidence")).to_contain_text("% sure")
    expect(page.get_by_text("1 new")).to_be_visible()
    page.keyboard.press("j")
    expect(page.locator(".case")).to_be_visible(timeout=SOON_MS)
    page.keyboard.press("r")
    expect(page.locator(f"li[data-victim='{robots}']")).to_have_attribute(
        "data-status", "reached", timeout=SOON_MS
    )
    expect(page.get_by_text("1 new")).to_have_count(0)
    page.locator(".case .history summary").click()
    page.locator(".case").get_by_role("button", name="Undo").click(timeout=SOON_MS)
    expect(page.get_by_text("1 new")).to_be_visible(timeout=SOON_MS)

    # what is marked grows, and nothing of it is erased
    page.locator(f"li[data-victim='{person}'] .card-body").click()
    case = page.locator(f"li[data-victim='{person}'] .case")
    marking = case.get_by_role("img", name="INSARAG")
    expect(marking.locator("text")).to_have_text(["L-2", "D-1"], timeout=SOON_MS)
    case.get_by_label("Live there").fill("0")
    case.get_by_label("Live there").press("Tab")
    expect(case.get_by_text("V, 1 dead still there")).to_be_visible(timeout=SOON_MS)
    expect(marking.locator("text")).to_have_text(["L-2", "D-1"])
    expect(marking.locator("path")).to_have_count(2)  # the V, and the stroke through L-2
    case.get_by_label("Dead there").fill("0")
    case.get_by_label("Dead there").press("Tab")
    expect(case.get_by_text("V, all known victims removed")).to_be_visible(timeout=SOON_MS)
    expect(case.locator("figcaption")).to_have_text(["INSARAG 2020, 2027", "FEMA", "FEMA, by some cards"])

    case.get_by_label("is the same as").select_option(robots)
    expect(cards).to_have_count(1, timeout=SOON_MS)
    case.get_by_role("button", name="Split off").click()
    expect(cards).to_have_count(2, timeout=SOON_MS)
    case.get_by_role("button", name="Move…").click()
    page.locator("#plan").click(position={"x": 300, "y": 300})
    expect(case.get_by_role("button", name="Where measured")).to_be_visible(timeout=SOON_MS)
    assert page.request.get(f"{api}/victims/{person}").json()["place_m"] is not None
    page.close()
    assert errors == []
