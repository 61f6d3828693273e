"""Twelve robots and a mission with a long name on a laptop's screen: all there, and nothing cut off."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path
from subprocess import DEVNULL, Popen
from sys import executable

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from server.benchmarks.browser import wait_for
from server.benchmarks.console_server import MISSION, ROBOTS

pytestmark = pytest.mark.browser

SOON_MS = 60_000
NAME = "Collapsed secondary school, north wing and gym, Bahnhofstrasse 112"
CUT_OFF = """(parts) => parts
  .filter((part) => part.scrollWidth > part.clientWidth || part.scrollHeight > part.clientHeight + 1)
  .map((part) => part.textContent)"""

PRESS = """(button, held_ms) => {
  const press = (type) => button.dispatchEvent(new PointerEvent(type, { button: 0, bubbles: true }));
  press("pointerdown");
  const until = performance.now() + held_ms;
  while (performance.now() < until);  // the page is too busy for its timers
  press("pointerup");
}"""


@pytest.fixture
def home(tmp_path: Path) -> Iterator[str]:
    """The address of a server with twelve robots that move."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    arguments = [executable, "-m", "server.benchmarks.console_server", str(port), str(tmp_path)]
    process = Popen(arguments, stdout=DEVNULL, stderr=DEVNULL)
    try:
        wait_for(f"http://127.0.0.1:{port}")
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        process.wait()


def assert_whole(page: Page, parts: str) -> None:
    assert page.locator(parts).evaluate_all(CUT_OFF) == []


def test_twelve_robots_have_room_on_a_laptop(browser: Browser, home: str) -> None:
    httpx.post(f"{home}/api/v1/missions", json={"name": NAME, "mission_id": "long"}).raise_for_status()
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    try:
        page.goto(f"{home}/console?mission={MISSION}")
        cards = page.locator(".robot-card")
        expect(cards).to_have_count(ROBOTS, timeout=SOON_MS)
        expect(page.locator(".robot-card[data-link=live]")).to_have_count(ROBOTS, timeout=SOON_MS)
        panel = page.locator("#robots").bounding_box()
        assert panel is not None
        for card in cards.all():
            box, stop = card.bounding_box(), card.get_by_role("button", name="Stop").bounding_box()
            assert box is not None
            assert stop is not None
            assert panel["y"] <= box["y"]
            assert box["y"] + box["height"] <= panel["y"] + panel["height"]
            assert min(stop["width"], stop["height"]) >= 36
        assert_whole(page, ".robot-card :is(.card-name, .state, .link, .figure-value)")

        # who is chosen has room for all that is known of it; a mission's name has the lines it needs
        cards.nth(11).locator(".card-body").click()
        expect(cards.nth(11).locator(".robot-orders")).to_be_visible()
        assert_whole(page, ".robot-card.selected :is(.card-name, .state, .link, .figure-value)")
        page.get_by_role("combobox", name="Mission").select_option("long")
        expect(page.locator(".mission-name")).to_have_text(NAME, timeout=SOON_MS)
        assert_whole(page, ".mission-name")

        # STOP counts how long it was held, not when a busy page notices
        page.get_by_role("combobox", name="Mission").select_option(MISSION)
        expect(cards).to_have_count(ROBOTS, timeout=SOON_MS)
        stop_all = page.get_by_role("button", name="STOP ALL")
        stop_all.evaluate(PRESS, 300)
        expect(stop_all).to_have_text("Press longer")
        with page.expect_request("**/stop", timeout=SOON_MS):
            stop_all.evaluate(PRESS, 700)
    finally:
        page.close()
