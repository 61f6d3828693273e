"""The whole story in a browser: make a mission, explore, find a victim and see to it, STOP, look back."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.small_robot import SmallRobot

pytestmark = pytest.mark.browser
SOON_MS = 60_000
FIRST_MS = 60_000  # the first observations may have to wait for the agent's kernels to compile
HELD_MS = 900


@pytest.fixture
def home(serve: Any, tmp_path: Path) -> str:
    return f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off', reply_s=60.0)))}"


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    yield page
    page.close()


def test_from_making_a_mission_to_handing_it_over(home: str, page: Page) -> None:
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))

    # a mission is made as a draft, started, and opened
    page.goto(f"{home}/missions")
    page.get_by_label("Name").fill("Collapsed school")
    page.get_by_label("As a draft").check()
    page.get_by_role("button", name="Make it").click()
    page.get_by_role("button", name="Start the mission: Collapsed school").click()
    expect(page.locator(".mission-running")).to_be_visible(timeout=SOON_MS)
    page.get_by_role("link", name="Collapsed school").click()
    expect(page.get_by_text("Waiting for robots")).to_be_visible(timeout=SOON_MS)
    mission = parse_qs(urlsplit(page.url).query)["mission"][0]

    with httpx.Client(base_url=home, timeout=90) as client:
        robots = [SmallRobot(client, name, mission) for name in ("r1", "r2")]
        try:
            _robots_explore_and_find_a_victim(page)
            _the_victim_is_seen_to(page)
            _all_robots_are_stopped(page)
            assert [(robot.linear, robot.angular) for robot in robots] == [(0.0, 0.0)] * 2
            _back_in_time_and_to_now(page)
            _handed_over(page, client, mission)
        finally:
            for robot in robots:
                robot.stop()
        assert [robot.failure for robot in robots] == [None, None]
    assert errors == []


def _robots_explore_and_find_a_victim(page: Page) -> None:
    expect(page.locator(".robot-card[data-link=live]")).to_have_count(2, timeout=FIRST_MS)
    expect(page.locator("canvas.building")).to_be_attached(timeout=SOON_MS)
    explored = page.locator(".bar-figure.explored dd").element_handle()
    page.wait_for_function("element => parseInt(element.textContent) > 15", arg=explored, timeout=FIRST_MS)
    expect(page.locator(".victim-card").first).to_be_visible(timeout=FIRST_MS)
    expect(page.locator(".alert-card", has_text="Victim").first).to_be_visible(timeout=SOON_MS)


def _the_victim_is_seen_to(page: Page) -> None:
    """The alert is taken note of; confirmed by a key, triaged step by step, given to a team."""
    page.get_by_role("button", name=re.compile("^Acknowledge: Victim")).first.click()
    expect(page.locator(".alert-card.noted").first).to_be_visible(timeout=SOON_MS)
    victim = page.locator(".victim-card").first
    page.keyboard.press("j")
    page.keyboard.press("c")
    expect(victim).to_have_attribute("data-status", "confirmed", timeout=SOON_MS)
    victim.get_by_role("button", name="No", exact=True).click()  # cannot walk
    victim.get_by_label("Breaths a minute").fill("34")
    victim.get_by_label("Breaths a minute").press("Enter")
    expect(victim.locator(".card-head .triage")).to_have_text("immediate", timeout=SOON_MS)
    victim.get_by_label("Team").fill("Rescue 2")
    victim.get_by_label("Team").press("Tab")
    expect(victim.get_by_text("Rescue 2 is on it")).to_be_visible(timeout=SOON_MS)
    page.keyboard.press("Escape")


def _all_robots_are_stopped(page: Page) -> None:
    page.get_by_role("button", name="STOP ALL").click(delay=HELD_MS)
    expect(page.locator(".robot-card[data-stop=free]")).to_have_count(0, timeout=SOON_MS)
    expect(page.get_by_text("All stopped", exact=True)).to_be_visible(timeout=SOON_MS)


def _back_in_time_and_to_now(page: Page) -> None:
    slider = page.get_by_label("Moment of the mission")
    expect(slider).to_be_visible(timeout=SOON_MS)
    page.wait_for_timeout(2_500)  # what was done last is in the past once that was recorded
    slider.focus()
    page.keyboard.press("Home")
    expect(page.locator(".past-banner")).to_contain_text("You look at")
    expect(page.locator(".victim-card")).to_have_count(0)  # nobody had been found then
    page.keyboard.press("End")
    page.get_by_role("button", name="Back to live").first.click()
    expect(page.locator(".past-banner")).to_have_count(0)
    expect(page.locator(".victim-card").first).to_have_attribute("data-status", "confirmed")


def _handed_over(page: Page, client: httpx.Client, mission: str) -> None:
    """The report stands for itself: one file that says what happened."""
    with page.context.expect_page() as opened:
        page.get_by_role("link", name="Report").click()
    report = opened.value
    expect(report.get_by_text("Collapsed school").first).to_be_visible(timeout=SOON_MS)
    for words in ("Rescue 2", "immediate", "STOP"):
        expect(report.get_by_text(words).first).to_be_attached()
    report.close()
    text = client.get(f"/api/v1/missions/{mission}/report.html").text
    assert not re.search(r'(?:src|href)="(?!data:|#)', text)  # it needs nothing else
