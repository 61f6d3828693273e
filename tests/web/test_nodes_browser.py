"""Nodes in a real browser, on the real server: one is hot, its alert is seen, opened and acknowledged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, expect

from robots.tags.marks import Note, Notes
from robots.tags.memory import CLOSED, OPEN, TagMemory
from robots.tags.sealed import close_memory
from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser

AT = "/api/v1/missions/drill"
SOON_MS = 60_000
KINDS = """(cells) => cells.map((cell) => cell.style.fill).sort()"""


class Hearing:
    """A robot that starts over node N7, drives away ahead, and hears N7 and N8 on its way."""

    def __init__(self, client: httpx.Client) -> None:
        self.client = client
        self.seq = 0
        client.post(
            "/api/v1/missions", json={"name": "Drill", "mission_id": "drill", "tag_key": ""}
        ).raise_for_status()
        start = {"x_m": 1.0, "y_m": 2.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
        robot = {"robot_id": "r1", "start_pose": start}
        client.post(f"{AT}/robots", json=robot).raise_for_status()

    def hear(self, temperature_c: float, times: int = 1) -> None:
        for _ in range(times):
            sensors = {"temperature_c": temperature_c, "pressure_hpa": 1013.2, "tilt_rad": 0.05}
            sightings: list[dict[str, Any]] = [
                *([{"tag_id": "N7"}] if self.seq == 0 else []),
                {"tag_id": "N7", "rssi_dbm": -20.0, "sensors": sensors},
                {"tag_id": "N8", "rssi_dbm": -35.0, "sensors": {"temperature_c": 19.0}},
            ]
            observation = {
                "seq": self.seq,
                "stamp_s": 1.0 * self.seq,
                "odometry": {"kind": "displacement", "dx_m": 0.5, "dy_m": 0.0, "dtheta_rad": 0.0},
                "tag_sightings": sightings,
            }
            self.seq += 1
            body = {"observations": [observation]}
            self.client.post(f"{AT}/robots/r1/observations", json=body, timeout=60).raise_for_status()

    def bring_memory(self) -> None:
        """Tell the server what is in N7: 3 by 4 cells covered, one of them open, and a note."""
        cells = np.zeros((5, 5), np.uint8)
        cells[1:4, 1:5] = CLOSED
        cells[2, 4] = OPEN
        memory = TagMemory(cells, notes=Notes((Note(1, "ann", "<b>stairs down</b>"),)))
        body = close_memory(memory, 1, "N7", b"", 150)
        headers = {"Content-Type": "application/octet-stream"}
        self.client.post(f"{AT}/tags/N7/memory", content=body, headers=headers).raise_for_status()


@pytest.fixture
def host(serve: Callable[[FastAPI], str], tmp_path: Path) -> str:
    return serve(create_app(Settings(data_dir=tmp_path, login="off", reply_s=60.0)))


@pytest.fixture
def hearing(host: str) -> Iterator[Hearing]:
    with httpx.Client(base_url=f"http://{host}", timeout=90) as client:
        yield Hearing(client)


@pytest.mark.parametrize("viewport", [(1280, 800), (360, 740)], ids=["desk", "phone"])
def test_a_hot_node_is_seen_opened_and_acknowledged(
    browser: Browser, hearing: Hearing, host: str, viewport: tuple[int, int]
) -> None:
    width, height = viewport
    page = browser.new_page(viewport={"width": width, "height": height}, has_touch=width < 900)
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    try:
        hearing.hear(21.0, times=6)
        page.goto(f"http://{host}/console")
        expect(page.locator(".connection")).to_have_text("Live", timeout=SOON_MS)
        expect(page.locator("#alerts")).to_be_empty()

        hearing.hear(85.0, times=2)
        if width < 900:
            page.locator("#tabs").get_by_role("button", name="Alerts").tap()
        card = page.locator(".alert-card[data-alert='hot:N7']")
        expect(card).to_contain_text("It is hot at node N7: 85 °C.", timeout=SOON_MS)
        expect(page.locator("#alarm-announcer")).to_contain_text("hot at node N7")
        expect(page.locator(".bar-figure.alerts dd")).to_have_text("1")
        mark = page.locator(".mark.alert[data-alert=N7]")
        expect(mark).to_contain_text("N7 · 85 °C", timeout=SOON_MS)

        # the tag's panel shows what it measures, and goes on doing so
        mark.click()
        panel = page.locator(".tag-card[data-tag=N7]")
        expect(panel.locator(".readings")).to_contain_text("85.0 °C")
        expect(panel.locator(".readings")).to_contain_text("1013.2 hPa")
        expect(panel).to_contain_text("Heard by r1")
        hearing.hear(90.0)
        expect(panel.locator(".readings")).to_contain_text("90.0 °C", timeout=SOON_MS)

        # and what its memory tells, as soon as somebody brings it
        expect(panel).to_contain_text("Nobody has read or written its memory yet.")
        hearing.bring_memory()
        expect(panel.locator("figcaption")).to_contain_text("It tells of 12 m² round it", timeout=SOON_MS)
        expect(panel.locator(".tag-sentences")).to_contain_text("<b>stairs down</b>")
        colours = panel.locator(".tag-memory rect").evaluate_all(KINDS)
        assert colours == ["var(--seen)"] * 11 + ["var(--warn)"]
        assert page.evaluate("document.documentElement.scrollWidth") <= width

        panel.get_by_role("button", name="Acknowledge: It is hot").click()
        expect(panel).to_contain_text("Noted by operator", timeout=SOON_MS)
        expect(page.locator(".bar-figure.alerts")).to_have_count(0)
        hearing.hear(20.0, times=11)
        expect(card).to_have_count(0, timeout=SOON_MS)
        expect(mark).to_have_count(0)
        panel.get_by_role("button", name="Close the card").click()
        expect(panel).to_have_count(0)
        assert errors == []
    finally:
        page.close()
