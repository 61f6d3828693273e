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
SOON_MS = 15_000


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
    page.get_by_role("slider").focus()
    page.keyboard.press("Home")
    expect(page.locator(".past-banner")).to_be_visible(timeout=SOON_MS)
    audit.look("console, past")
    page.set_viewport_size({"width": 390, "height": 844})
    audit.look("console, past on a phone")
    back = page.locator(".time-live").bounding_box()
    assert back is not None
    assert back["x"] + back["width"] <= 390  # the way back to now is in sight
    page.locator(".time-live").click()
    expect(page.locator(".past-banner")).to_have_count(0)
    page.get_by_role("button", name="Map tools").click()
    audit.look("console, tools on a phone")
    page.set_viewport_size({"width": 1366, "height": 768})

    page.goto(f"{home}/missions")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    audit.look("missions")
    page.goto(f"{home}/people")
    page.get_by_label("What it is for").fill("red rover")
    page.get_by_role("button", name="Make a token").click()
    expect(page.locator(".secret")).to_be_visible()
    audit.look("people")
    page.goto(f"{home}/t/{seen['tag']}")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    audit.look("phone at a tag")
    page.get_by_role("button", name=f"Victim {seen['victim']}").click()
    expect(page.locator(".go .number")).to_be_visible(timeout=SOON_MS)
    audit.look("phone, led to a victim")
    assert not audit.found, "\n".join(audit.found)
