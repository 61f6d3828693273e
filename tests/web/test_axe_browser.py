"""Every page in every state, as axe-core and a keyboard find it."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.axe import Audit
from tests.web.driven import drive

pytestmark = pytest.mark.browser
SOON_MS = 60_000


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_context(viewport={"width": 1366, "height": 768}).new_page()
    yield page
    page.context.close()


@pytest.fixture
def link(serve: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The link of the first start."""
    host = serve(create_app(Settings(data_dir=tmp_path, login="on", reply_s=60.0)))
    out = ""
    while "/join#" not in out:
        out += capsys.readouterr().out
        time.sleep(0.05)
    return f"http://{host}" + re.search(r"http://[^/]+(/join#\S+)", out)[1]  # type: ignore[index]


def test_every_page_and_state_has_no_violation(link: str, page: Page, robot_log: Any) -> None:
    home = link.split("/join")[0]
    audit = Audit(page)
    page.goto(f"{home}/login")
    expect(page.get_by_role("button", name="Log in")).to_be_visible()
    audit.look("login")
    page.goto(link)
    audit.look("join")
    page.get_by_label("Your name").fill("Ada")
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Join").click()
    expect(page.get_by_text("No mission yet")).to_be_visible(timeout=SOON_MS)
    audit.look("console without a mission")

    seen = drive(page.request, home, robot_log)
    expect(page.locator(".victim-card")).to_be_visible(timeout=SOON_MS)
    audit.look("console with a mission")
    page.get_by_label("Logged in as Ada").click()
    audit.look("console, account")
    page.get_by_label("Look of this page").click()
    audit.look("console, look")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Layers").click()
    page.locator(".robot-card .card-body").click()
    audit.look("console, robot and layers")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    audit.look("console, keys")
    page.keyboard.press("Escape")
    page.keyboard.press("m")
    page.get_by_label("Find a robot").fill("r")
    audit.look("console, measuring and finding")
    page.get_by_role("button", name="Note", exact=True).click()
    page.keyboard.press("j")
    expect(page.locator(".case")).to_be_visible()
    audit.look("console, victim and note")
    page.keyboard.press("b")
    audit.look("console, best map")
    page.keyboard.press("b")

    page.goto(f"{home}/missions")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    audit.look("missions")
    page.goto(f"{home}/people")
    page.get_by_label("What it is for").fill("red rover")
    page.get_by_role("button", name="Make a token").click()
    expect(page.locator(".secret")).to_be_visible()
    audit.look("people")
    empty = 'id="told"></script>'
    assert empty not in page.request.get(f"{home}/t/{seen['tag']}").text()
    assert page.context.browser is not None
    stranger = page.context.browser.new_context()
    assert empty in stranger.request.get(f"{home}/t/{seen['tag']}").text()  # who may not ask is told nothing
    stranger.close()
    page.goto(f"{home}/t/{seen['tag']}")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    audit.look("phone at a tag")
    page.get_by_role("button", name=f"Victim {seen['victim']}").click()
    expect(page.locator(".go .number")).to_be_visible(timeout=SOON_MS)
    audit.look("phone, led to a victim")
    page.set_viewport_size({"width": 390, "height": 844})
    audit.look_in_gloves("phone, led to a victim")
    assert page.request.delete(f"{home}/api/v1/session", headers={"Origin": home}).ok
    page.get_by_role("button", name="Leave word here").click()
    page.get_by_role("button", name="Searched").click()
    expect(page.get_by_text("You are logged out.")).to_be_visible(timeout=SOON_MS)
    audit.look_in_gloves("phone, logged out")
    page.goto(f"{home}/login?next=/phone")
    expect(page.get_by_role("button", name="Log in")).to_be_visible()
    audit.look("login on a phone")
    assert not audit.found, "\n".join(audit.found)


def _apart(page: Page, one: str, other: str) -> bool:
    a, b = page.locator(one).bounding_box(), page.locator(other).bounding_box()
    assert a is not None
    assert b is not None
    aside = a["x"] + a["width"] <= b["x"] or b["x"] + b["width"] <= a["x"]
    return aside or a["y"] + a["height"] <= b["y"] or b["y"] + b["height"] <= a["y"]


def test_the_past_and_a_phone_have_no_violation(serve: Any, tmp_path: Path, page: Page) -> None:
    home = f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off')))}"
    api, headers = f"{home}/api/v1/missions", {"Origin": home}
    assert page.request.post(api, data={"name": "Drill", "mission_id": "drill"}, headers=headers).ok
    for k in range(3):
        note = {"kind": "hazard", "text": f"Gas {k}", "x_m": 2.0 * k, "y_m": 0.0}
        path = f"{api}/drill/annotations/00000000-0000-4000-8000-{k:012d}"
        assert page.request.put(path, data=note, headers=headers).ok
    audit = Audit(page)
    page.goto(home)
    marks = page.locator("#plan .mark.note")
    expect(marks).to_have_count(3, timeout=SOON_MS)
    page.get_by_label("Moment of the mission").focus()
    page.keyboard.press("Home")
    banner = page.locator(".past-banner span")
    expect(banner).to_be_visible(timeout=SOON_MS)
    audit.look("console, past")
    page.set_viewport_size({"width": 390, "height": 844})
    audit.look("console, past on a phone")
    # what the banner says is not covered, and the way back to now is in sight
    assert _apart(page, ".past-banner span", "button.evacuate")
    assert _apart(page, ".past-banner span", ".views")
    back = page.locator(".time-live").bounding_box()
    assert back is not None
    assert back["x"] + back["width"] <= 390
    page.locator(".time-live").click()
    expect(banner).to_have_count(0)

    # in one hand: what must be quick lies in the lower half, and the mission's menu opens within the screen
    for button in (".evacuate", ".stop-all"):
        box = page.locator(button).bounding_box()
        assert box is not None
        assert box["y"] > 844 * 0.6
        assert 0 <= box["x"] <= box["x"] + box["width"] <= 390
        assert all(_apart(page, button, other) for other in ("#tabs", "#time", "#robots", "#stage"))
    assert _apart(page, ".evacuate", ".stop-all")
    page.locator(".mission-menu summary").click()
    card = page.locator(".mission-menu .pop-card").bounding_box()
    assert card is not None
    assert 0 <= card["x"] <= card["x"] + card["width"] <= 390
    report = page.get_by_role("link", name="Report to hand over")
    assert page.request.get(home + str(report.get_attribute("href"))).ok
    audit.look("console, mission menu on a phone")
    page.keyboard.press("Escape")

    # the map is free of tools until they are wanted; where a place is asked for, it takes the room
    stage = page.locator("#stage")
    before = stage.bounding_box()
    expect(page.get_by_role("button", name="Sectors")).to_be_hidden()
    page.get_by_role("button", name="Map tools").click()
    audit.look("console, tools on a phone")
    page.get_by_role("button", name="Note", exact=True).click()
    page.get_by_label("What it says").fill("Stairs down")
    page.get_by_role("button", name="At a point").click()
    expect(page.locator("#robots")).to_be_hidden()
    after = stage.bounding_box()
    assert before is not None
    assert after is not None
    assert after["height"] > 1.5 * before["height"]
    audit.look("console, a place is asked for on a phone")
    page.locator("#plan").click(position={"x": 120, "y": 200})
    expect(page.get_by_role("button", name="hazard: Stairs down")).to_be_visible(timeout=SOON_MS)
    expect(page.locator("#robots")).to_be_visible()

    visit = {"team": "AUS01", "level": 3, "entered_unix_s": time.time() - 60}
    worksite = {"worksite_id": "C-5", "hazards": "gas", "triage": "B", "visits": [visit]}
    sector = {"name": "C", "area_m": [[0, 0], [4, 0], [4, 4]], "worksite": worksite}
    assert page.request.put(f"{api}/drill/sectors/{path[-36:]}", data=sector, headers=headers).ok
    page.get_by_role("button", name="Sectors").click()
    page.locator(".sector-list button").click(timeout=SOON_MS)
    expect(page.get_by_role("img", name="FEMA search: AUS01 is inside")).to_be_visible()
    audit.look("console, worksite on a phone")
    assert not audit.found, "\n".join(audit.found)
