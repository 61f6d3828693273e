"""The report in a real browser: its film plays, it prints, and hostile words stay words."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, expect

from robots.client import RobotClient
from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser

HOSTILE = "</script><script>window.hacked = 1</script><img src=x onerror='window.hacked=1'>"


def test_a_report_plays_and_prints(browser: Browser, serve: Callable[[FastAPI], str], tmp_path: Path) -> None:
    host = serve(create_app(Settings(data_dir=tmp_path, login="off")))
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        client.post("/missions", json={"name": HOSTILE, "mission_id": "m"}).raise_for_status()
        robot = RobotClient(f"http://{host}", "m", "r1", patience_s=60.0)
        robot.register(start_pose={"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01})
        for seq in range(25):
            still = {"kind": "displacement", "dx_m": 0.05, "dy_m": 0.0, "dtheta_rad": 0.0}
            robot.post([{"seq": seq, "stamp_s": 0.2 * seq, "odometry": still}])
            if seq % 8 == 0:
                client.post("/missions/m/stop", json={"robots": ["r1"]}).raise_for_status()
        robot.close()
        words = {"kind": "note", "text": HOSTILE, "x_m": 1.0, "y_m": 1.0}
        note = "/missions/m/annotations/5b0c3f2e-9d2e-4c2f-8a43-000000000001"
        client.put(note, json=words).raise_for_status()
        page_file = tmp_path / "report.html"
        page_file.write_text(client.get("/missions/m/report.html").text)
    page = browser.new_page(viewport={"width": 1000, "height": 900})
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(page_file.as_uri())
    expect(page.locator("h1")).to_have_text(HOSTILE)
    expect(page.locator("#player output")).to_have_text(re.compile(r"\d\d:\d\d:\d\d"))
    page.locator("#player input").focus()
    page.keyboard.press("Home")
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    page.locator(".timeline time").first.click()
    assert page.evaluate("window.hacked") is None
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    pdf = page.pdf(prefer_css_page_size=True)
    assert pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ") >= 2
    assert errors == []
    page.close()
