"""What lies over the plan in a real browser: scale, north, following a robot, layers drawn or not."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.driven import drive

pytestmark = pytest.mark.browser
SOON_MS = 60_000
ZOOM = 0.75  # of a doubling, by the button


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_context(viewport={"width": 1366, "height": 768}).new_page()
    yield page
    page.context.close()


@pytest.fixture
def home(serve: Any, tmp_path: Path) -> str:
    return f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off', reply_s=60.0)))}"


def _ink(page: Page) -> list[str]:
    """What the canvases over the building hold."""
    found: list[str] = page.evaluate(
        "[...document.querySelectorAll('.leaflet-ink-pane canvas')].map(canvas => canvas.toDataURL())"
    )
    assert found
    return found


def _wait_until_still(page: Page) -> None:
    page.wait_for_function(
        """async () => {
          const drawn = () => [...document.querySelectorAll(".leaflet-ink-pane canvas")];
          const ink = () => drawn().map((canvas) => canvas.toDataURL()).join();
          const before = ink();
          await new Promise((resolve) => setTimeout(resolve, 400));
          return before === ink();
        }""",
        timeout=SOON_MS,
    )


def _metres_a_pixel(page: Page) -> float:
    bar = page.get_by_label(re.compile("^Scale: this bar is"))
    length, unit = bar.inner_text().split()
    box = bar.locator("i").bounding_box()
    assert box is not None
    return float(length) * {"m": 1.0, "cm": 0.01}[unit] / box["width"]


def _off_the_middle(page: Page) -> float:
    """How far the robot's mark is from the middle of the plan, in pixels."""
    plan, robot = page.locator("#plan").bounding_box(), page.get_by_label("Robot r1").bounding_box()
    assert plan is not None
    assert robot is not None
    return max(
        abs(robot[at] + robot[side] / 2 - plan[at] - plan[side] / 2)
        for at, side in (("x", "width"), ("y", "height"))
    )


def test_scale_north_and_following(home: str, page: Page, robot_log: Any) -> None:
    drive(page.request, home, robot_log)
    page.goto(home)
    page.locator(".robot-card .card-body").click(timeout=SOON_MS)

    before = _metres_a_pixel(page)
    page.get_by_role("button", name="Zoom in").click()
    _wait_until_still(page)
    assert before / _metres_a_pixel(page) == pytest.approx(2.0**ZOOM, rel=0.05)

    expect(page.get_by_label("North is to the right")).to_be_visible()
    place = {"origin": {"lat_deg": 48.1, "lon_deg": 11.5}, "yaw_rad": 1.0}
    there = f"{home}/api/v1/missions/drill/georeference"
    assert page.request.put(there, data=place, headers={"Origin": home}).ok
    expect(page.get_by_label("North is 57 degrees clockwise from up")).to_be_visible(timeout=SOON_MS)

    follow = page.get_by_role("button", name="Follow")
    follow.click()
    expect(follow).to_have_attribute("aria-pressed", "true")
    _wait_until_still(page)
    assert _off_the_middle(page) < 30.0
    page.mouse.move(500, 400)
    page.mouse.down()
    page.mouse.move(700, 500, steps=5)
    page.mouse.up()
    expect(follow).to_have_attribute("aria-pressed", "false")  # who moves the plan looks at something else
    assert _off_the_middle(page) > 60.0


def test_layers_are_drawn_or_not_and_remembered(home: str, page: Page, robot_log: Any) -> None:
    drive(page.request, home, robot_log)
    page.goto(home)
    page.locator(".robot-card .card-body").click(timeout=SOON_MS)
    page.get_by_role("button", name="Layers").click()
    for layer in ("Trails", "Uncertainty", "Plan of selected robot", "Edges of the unknown", "Links between"):
        box = page.get_by_label(re.compile(f"^{layer}"))
        _wait_until_still(page)
        with_it = _ink(page)
        box.uncheck()
        _wait_until_still(page)
        assert _ink(page) != with_it, f"{layer}: nothing was drawn"
        box.check()
        _wait_until_still(page)
        assert _ink(page) == with_it
    page.get_by_label(re.compile("^Trails")).uncheck()
    page.reload()
    page.get_by_role("button", name="Layers").click(timeout=SOON_MS)
    expect(page.get_by_label(re.compile("^Trails"))).not_to_be_checked()
