"""The console's place on the Earth: its arithmetic against the server's, and what people see and type."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.geo.georeference import Georeference
from server.geo.mgrs import to_mgrs
from server.settings import Settings

pytestmark = pytest.mark.browser
SOON_MS = 60_000


@pytest.fixture
def host(serve: Callable[[FastAPI], str], tmp_path: Path) -> str:
    return serve(create_app(Settings(data_dir=tmp_path, login="off")))


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    yield page
    page.close()


def frames() -> list[tuple[Georeference, float, float]]:
    random = np.random.default_rng(7)
    lows, highs = (-79.5, -179.9, -3.1, -50.0), (83.5, 179.9, 3.1, 3000.0)
    drawn = [random.uniform(lows, highs) for _ in range(300)]
    return [(Georeference(*map(float, row)), *map(float, random.uniform(-400, 400, 2))) for row in drawn]


def test_places_are_those_of_the_server(page: Page, host: str) -> None:
    page.goto(f"http://{host}/static/logo.svg")
    rows: list[dict[str, Any]] = [
        {"frame": {n: getattr(f, n) for n in Georeference.__slots__}, "x_m": x, "y_m": y}
        for f, x, y in frames()
    ]
    told = page.evaluate(
        """async (rows) => {
          const { toEarth, toMgrs } = await import("/static/console/earth.js");
          return rows.map(({ frame, x_m, y_m }) => {
            const at = toEarth(frame, x_m, y_m);
            return [...at, toMgrs(...at)];
          });
        }""",
        rows,
    )
    for (frame, x, y), (lat, lon, grid) in zip(frames(), told, strict=True):
        assert (lat, lon) == pytest.approx(frame.to_earth(x, y), abs=1e-9)
        assert grid == to_mgrs(lat, lon)


def test_a_mission_is_placed_and_every_point_then_has_a_grid_reference(page: Page, host: str) -> None:
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        client.post("/missions", json={"name": "Mine"}).raise_for_status()
        page.goto(f"http://{host}/console")
        expect(page.get_by_role("img", name="North is to the right")).to_be_visible(timeout=SOON_MS)
        page.locator(".mission-menu summary").click()
        page.get_by_role("button", name="Place on the Earth…").click()
        panel = page.locator(".georeference")
        for k, typed in ((1, "32U PU 91607 34903"), (2, "32U PU 91607 34904")):
            panel.get_by_role("button", name=f"Point {k}").click()
            page.locator("#plan").click(position={"x": 100 + 100 * k, "y": 400})
            panel.get_by_label(f"Point {k} on the Earth").fill(typed)
        panel.get_by_role("button", name="Keep").click()
        expect(panel.get_by_role("alert")).to_contain_text("apart", timeout=SOON_MS)
        panel.get_by_role("button", name="By origin and heading").click()
        panel.get_by_label("Origin").fill("48.137154, 11.576124")
        panel.get_by_label("Compass bearing").fill("0")
        expect(panel.get_by_role("button", name="Keep")).to_be_enabled(
            timeout=SOON_MS
        )  # it is drawn a frame later
        panel.get_by_label("Compass bearing").press("Tab")
        panel.get_by_role("button", name="Keep").press("Enter")
        expect(panel).to_have_count(0, timeout=SOON_MS)
        expect(page.get_by_role("img", name="North is 90 degrees clockwise from up")).to_be_visible()
        page.locator("#plan").hover(position={"x": 400, "y": 300})
        expect(page.locator(".cursor")).to_contain_text("32U PU 9")
        placed = client.get("/missions/mine/georeference").json()
        assert (placed["lat_deg"], placed["lon_deg"]) == (48.137154, 11.576124)
