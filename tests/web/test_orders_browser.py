"""Orders in a real browser, on the real server: on a robot's card, by its menu and by a click on the plan."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from robots.client import RobotClient
from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser

SOON_MS = 60_000


class Waiting:
    """A robot in the middle of a bare hall, that says what its laser sees whenever it is asked to."""

    def __init__(self, host: str) -> None:
        self.client = RobotClient(f"http://{host}", "drill", "r1", patience_s=60.0)
        self.seq = 0
        self.client.create_mission("Drill")
        self.client.register(
            start_pose={"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
        )

    def speak(self, times: int = 1) -> Any:
        ranges = {"ranges_m": [3.0] * 90, "range_max_m": 4.0}
        scan = {**ranges, "angle_min_rad": -2.0, "angle_increment_rad": 0.045}
        still = {"kind": "displacement", "dx_m": 0.0, "dy_m": 0.0, "dtheta_rad": 0.0}
        for _ in range(times):
            observation = {
                "seq": self.seq,
                "stamp_s": 0.2 * self.seq,
                "odometry": still,
                "scan": scan,
                "tags_left": 0,
            }
            self.seq += 1
            reply = self.client.post([observation])
        return reply


def _pick_a_place(page: Page) -> None:
    plan = page.locator("#plan")
    expect(plan).to_have_class(re.compile("picking"))
    box = plan.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.62 * box["height"])


@pytest.mark.parametrize("viewport", [(1366, 768), (390, 844)], ids=["desk", "phone"])
def test_a_robot_is_ordered_about(
    browser: Browser, serve: Callable[[FastAPI], str], tmp_path: Path, viewport: tuple[int, int]
) -> None:
    host = serve(create_app(Settings(data_dir=tmp_path, login="off")))
    robot = Waiting(host)
    robot.speak(12)
    width, height = viewport
    page = browser.new_page(viewport={"width": width, "height": height})
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    try:
        page.goto(f"http://{host}/console")
        card = page.locator('.robot-card[data-robot="r1"]')
        card.locator(".card-body").click(timeout=SOON_MS)
        state = card.locator(".order-state").last

        card.get_by_role("button", name="Hold").click()
        expect(state).to_contain_text("Hold: waiting to be heard", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text("Hold: done, standing still", timeout=SOON_MS)
        expect(card.locator(".reason")).to_contain_text("standing still, ordered by", timeout=SOON_MS)

        card.get_by_label("Explores by").select_option("nearest")
        expect(state).to_contain_text("Explore by nearest", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text("Explore by nearest: done", timeout=SOON_MS)
        card.get_by_label("Shares out by").select_option("hungarian")
        expect(state).to_contain_text("Share out by hungarian: waiting", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text("Share out by hungarian: done", timeout=SOON_MS)
        expect(card.get_by_text("It hears nobody by tags")).to_be_visible(timeout=SOON_MS)
        card.get_by_label("Hears others by").select_option("full")
        expect(state).to_contain_text("Hear others by full: waiting", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text("Hear others by full: done", timeout=SOON_MS)
        expect(card.get_by_text("It hears nobody")).to_have_count(0)

        card.get_by_role("button", name="Go to").click()
        _pick_a_place(page)
        expect(state).to_contain_text("Go to: waiting to be heard", timeout=SOON_MS)
        assert robot.speak(6)["command"] != {"linear_mps": 0.0, "angular_radps": 0.0}
        expect(state).to_contain_text(re.compile("Go to: (under way|done)"), timeout=SOON_MS)

        card.get_by_role("button", name="Return").click()
        expect(state).to_contain_text("Return: waiting to be heard", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text(re.compile("Return: (under way|done)"), timeout=SOON_MS)
        card.get_by_role("button", name="Resume").click()
        expect(state).to_contain_text("Resume exploring: waiting to be heard", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text("Resume exploring: done, exploring", timeout=SOON_MS)
        card.get_by_role("button", name="Explore here").click()
        _pick_a_place(page)
        expect(state).to_contain_text("Explore here: waiting to be heard", timeout=SOON_MS)
        robot.speak(2)
        expect(state).to_contain_text(re.compile("Explore here: (under way|done)"), timeout=SOON_MS)

        # what cannot be done says why, and still does to whoever opens the page anew
        card.get_by_role("button", name="Drop tag").click()
        expect(state).to_contain_text("Drop a tag: waiting to be heard", timeout=SOON_MS)
        robot.speak(2)
        failed = "Drop a tag: failed, the magazine is empty."
        expect(state).to_contain_text(failed, timeout=SOON_MS)
        page.reload()
        card.locator(".card-body").click(timeout=SOON_MS)
        expect(state).to_contain_text(failed, timeout=SOON_MS)
        assert errors == []
    finally:
        page.close()
        robot.client.close()
