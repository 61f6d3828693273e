"""Sectors in a real browser: drawn corner by corner, given to a team, opened again from the plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser
SOON_MS = 60_000


@pytest.fixture
def host(serve: Callable[[FastAPI], str], tmp_path: Path) -> str:
    return serve(create_app(Settings(data_dir=tmp_path, login="off")))


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    yield page
    page.close()
    assert errors == []


def test_a_sector_is_drawn_assigned_judged_and_opened_again(page: Page, host: str) -> None:
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        client.post("/missions", json={"name": "Mine"}).raise_for_status()
        page.goto(f"http://{host}/console")
        page.get_by_role("button", name="Sectors").click(timeout=SOON_MS)
        panel = page.locator(".sectors")
        panel.get_by_role("button", name="Begin a period…").click()
        panel.get_by_label("Commander").fill("Ada")
        panel.get_by_role("button", name="Begin", exact=True).press("Enter")
        expect(panel.locator(".period")).to_contain_text("Operational period 1 under Ada", timeout=SOON_MS)
        panel.get_by_role("button", name="Draw a sector…").click()
        for x, y in ((150, 340), (350, 340), (350, 480), (150, 480)):
            page.locator("#plan").click(position={"x": x, "y": y})
        drawing = page.get_by_role("region", name="Draw a sector")
        expect(drawing.get_by_text("4 so far")).to_be_visible()
        plan, strip = page.locator("#plan").bounding_box(), drawing.bounding_box()
        assert plan is not None
        assert strip is not None
        assert strip["height"] < plan["height"] / 5  # nearly all of the plan is free to be drawn on
        page.locator("#plan").click(position={"x": 600, "y": 200})
        drawing.get_by_role("button", name="Last corner off").click()
        drawing.get_by_label("Name").fill("<b>B2</b>")
        drawing.get_by_role("button", name="Close the sector", exact=True).click()
        expect(panel.get_by_role("heading", name="Sector <b>B2</b>")).to_be_visible(timeout=SOON_MS)
        panel.get_by_label("Team of people").fill("AUS01")
        panel.get_by_label("Team of people").press("Tab")
        expect(panel.get_by_label("Status")).to_have_value("under_way", timeout=SOON_MS)
        panel.get_by_label("Status").select_option("searched")
        expect(panel.get_by_role("button", name="Send its robots there")).to_be_disabled()
        panel.get_by_role("button", name="All sectors").click()
        expect(panel.locator(".sector-list")).to_contain_text("Searched: AUS01", timeout=SOON_MS)
        panel.get_by_role("button", name="Close the sectors").click()
        page.locator("#plan").click(position={"x": 250, "y": 400})
        expect(panel.get_by_label("Status")).to_have_value("searched")
        (sector,) = client.get("/missions/mine/sectors").json()["sectors"]
        assert (sector["name"], sector["team"], sector["period"]) == ("<b>B2</b>", "AUS01", 1)
        panel.get_by_role("button", name="Remove").click()
        expect(panel.get_by_text("No part of the ground is a sector yet.")).to_be_visible(timeout=SOON_MS)
