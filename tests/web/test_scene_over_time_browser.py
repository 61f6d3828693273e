"""The 3D view in the past, and when nothing comes any more: what lies over it in a real browser."""

from __future__ import annotations

import re
import uuid
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser

SOON_MS = 60_000  # a page with scenes that are drawn in software
ON_TOP = """(selector) => {
  const { left, top, width, height } = document.querySelector("#scene-pane").getBoundingClientRect();
  return document.elementFromPoint(left + width / 2, top + height / 2)?.closest(selector) !== null;
}"""


def on_top(page: Page, selector: str) -> None:
    """Wait until what is in the middle of the 3D view lies within what a selector names."""
    page.wait_for_function(ON_TOP, arg=selector, timeout=SOON_MS)


def move_to(page: Page, share: float) -> None:
    page.get_by_label("Moment of the mission").evaluate(
        """(slider, share) => {
          slider.value = String(share * Number(slider.max));
          slider.dispatchEvent(new Event("input", { bubbles: true }));
        }""",
        share,
    )


def test_the_past_and_the_veil_lie_over_the_3d_view(browser: Browser, serve: Any, tmp_path: Path) -> None:
    app = create_app(Settings(data_dir=tmp_path, login="off"))
    host = serve(app)
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=60) as client:
        client.post("/missions", json={"name": "Drill", "mission_id": "drill"}).raise_for_status()
        note = f"/missions/drill/annotations/{uuid.uuid4()}"
        for x_m in (1.0, 2.0):
            words = {"kind": "hazard", "text": "gas", "x_m": x_m, "y_m": 0.0}
            client.put(note, json=words).raise_for_status()
    page = browser.new_page(viewport={"width": 1000, "height": 560})
    try:
        page.goto(f"http://{host}/console")
        page.get_by_role("button", name="3D", exact=True).click(timeout=SOON_MS)
        live = page.frame_locator("#scene-pane > iframe")
        expect(live.locator("canvas").first).to_be_visible(timeout=SOON_MS)
        on_top(page, "#scene-pane > iframe")

        move_to(page, 0.1)
        past = page.frame_locator(".past-scene iframe")
        expect(past.locator("canvas").first).to_be_visible(timeout=SOON_MS)
        on_top(page, ".past-scene")
        page.locator("#banner").get_by_role("button", name="Back to live").click()
        on_top(page, "#scene-pane > iframe")

        serve.stop(host)
        on_top(page, "#veil")
        expect(page.locator("#veil")).to_contain_text(re.compile(r"STALE since \d\d:\d\d:\d\d"))
        expect(page.get_by_role("button", name="Try now")).to_be_in_viewport(ratio=1)
    finally:
        page.close()
