"""What lies under the map, taken away and brought back in the console."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, expect

from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser
SOON_MS = 60_000


def test_a_base_map_is_taken_away_and_brought_back(serve: Any, tmp_path: Path, browser: Browser) -> None:
    host = serve(create_app(Settings(data_dir=tmp_path, login="off")))
    picture = io.BytesIO()
    Image.fromarray(np.full((40, 60), 254, np.uint8)).save(picture, "PNG")
    with httpx.Client(base_url=f"http://{host}/api/v1/missions", timeout=90) as client:
        client.post(f"http://{host}/api/v1/missions", json={"name": "Drill", "mission_id": "drill"})
        words: dict[str, str | float] = {"resolution_m": 0.2, "source": "<b>cellar</b>.png"}
        png = picture.getvalue()
        client.put("/drill/base-map", params=words, content=png).raise_for_status()
    page = browser.new_context(viewport={"width": 1366, "height": 768}).new_page()
    page.goto(f"http://{host}")
    menu = page.locator(".mission-menu")
    menu.locator("summary").click(timeout=SOON_MS)
    expect(menu).to_contain_text("Under the map: <b>cellar</b>.png, laid by")
    plan = page.locator(".leaflet-base-pane canvas")
    expect(plan).to_be_attached(timeout=SOON_MS)
    menu.get_by_role("button", name="Take the base map away").click()
    expect(menu).to_contain_text("No plan lies under the map.", timeout=SOON_MS)
    expect(plan).not_to_be_attached()
    menu.get_by_role("button", name="Take back its last change").click()
    expect(menu).to_contain_text("Under the map: <b>cellar</b>.png, laid by", timeout=SOON_MS)
    expect(plan).to_be_attached(timeout=SOON_MS)
    # and the laying of it as well; then there is nothing left to take back
    menu.get_by_role("button", name="Take back its last change").click()
    expect(menu).to_contain_text("No plan lies under the map.", timeout=SOON_MS)
    menu.get_by_role("button", name="Take back its last change").click()
    expect(page.locator("#notices")).to_contain_text("Nobody has changed what lies under the map.")
    page.context.close()
