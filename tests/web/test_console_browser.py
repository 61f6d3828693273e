"""The console in a real browser, on the real server: a robot moves, a victim appears, STOP works."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, ConsoleMessage, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.small_robot import MISSION, SmallRobot

pytestmark = pytest.mark.browser

SOON_MS = 60_000
FIRST_MS = 60_000  # the first observations may have to wait for the agent's kernels to compile
HELD_MS = 900  # what has to be held for 600 ms


@pytest.fixture
def host(serve: Callable[[FastAPI], str], tmp_path: Path) -> str:
    return serve(create_app(Settings(data_dir=tmp_path, login="off", reply_s=60.0)))


@pytest.fixture
def client(host: str) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=f"http://{host}", timeout=90) as client:
        yield client


class OpenPage:
    """A page and the errors it logged."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.errors: list[str] = []
        page.on("console", self._log)
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    def _log(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.errors.append(message.text)


@pytest.fixture
def opened(browser: Browser) -> Iterator[OpenPage]:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    yield OpenPage(page)
    page.close()


def create_mission(client: httpx.Client) -> None:
    client.post("/api/v1/missions", json={"name": "Drill", "mission_id": MISSION}).raise_for_status()


def test_an_empty_server_says_how_to_begin_and_opens_the_first_mission(
    opened: OpenPage, client: httpx.Client, host: str
) -> None:
    page = opened.page
    page.goto(f"http://{host}/")
    expect(page.get_by_text("No mission yet")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_role("button", name="STOP ALL")).to_be_disabled()
    create_mission(client)
    expect(page.get_by_text("Waiting for robots")).to_be_visible(timeout=SOON_MS)
    expect(page.locator(".connection")).to_have_text("Live")
    assert opened.errors == []


def test_an_unknown_mission_is_named_as_the_reason(opened: OpenPage, client: httpx.Client, host: str) -> None:
    create_mission(client)
    opened.page.goto(f"http://{host}/console?mission=nowhere")
    expect(opened.page.get_by_text("This mission cannot be shown")).to_be_visible(timeout=SOON_MS)


def test_a_mission_is_watched_and_stopped(
    opened: OpenPage, client: httpx.Client, host: str, serve: Any
) -> None:
    page = opened.page
    create_mission(client)
    robot = SmallRobot(client, "r1")
    try:
        page.goto(f"http://{host}/console")
        card = page.locator(".robot-card[data-robot=r1]")
        mark = page.locator(".mark.robot[data-robot=r1]")
        expect(card).to_have_attribute("data-link", "live", timeout=FIRST_MS)
        expect(mark).to_be_visible()

        # it moves, and the building grows around it
        page.wait_for_function(
            "() => parseFloat(document.querySelectorAll('.robot-card .figure-value')[2].textContent) > 0.5",
            timeout=FIRST_MS,
        )
        expect(page.locator("canvas.building")).to_be_attached(timeout=SOON_MS)
        explored = page.locator(".bar-figure", has_text="Explored").locator("dd")
        page.wait_for_function("element => parseInt(element.textContent) > 10", arg=explored.element_handle())

        # a victim appears, and its status is changed by hand
        victim = page.locator(".victim-card").first
        expect(victim).to_be_visible(timeout=FIRST_MS)
        expect(page.locator(".mark.victim").first).to_be_attached()
        victim.get_by_label("Status").select_option("confirmed")
        expect(victim).to_have_attribute("data-status", "confirmed", timeout=SOON_MS)

        # what is found out is kept: START step by step, counts, and a place that a person points at
        page.keyboard.press("j")
        expect(victim).to_have_class(re.compile("selected"))
        victim.get_by_role("button", name="No", exact=True).click()  # cannot walk
        victim.get_by_label("Breaths a minute").fill("34")
        victim.get_by_label("Breaths a minute").press("Enter")
        expect(victim.locator(".card-head .triage")).to_have_text("immediate", timeout=SOON_MS)
        expect(victim.get_by_text("cannot walk, breathes 34 times a minute")).to_be_visible()
        victim.get_by_label("Live there").fill("1")
        victim.get_by_label("Live there").press("Tab")
        expect(victim.get_by_text("V, 1 live still there")).to_be_visible(timeout=SOON_MS)
        victim.get_by_text("History").click()
        expect(victim.locator(".history li").first).to_contain_text("live there 1", timeout=SOON_MS)
        victim.get_by_role("button", name="Undo").click()
        expect(victim.get_by_text("V: a potential victim")).to_be_visible(timeout=SOON_MS)
        expect(victim.locator(".history li").first).to_contain_text("took a change back", timeout=SOON_MS)
        page.keyboard.press("Escape")

        # selecting shows the plan; STOP is confirmed, RESUME asks twice
        card.locator(".card-body").click()
        expect(card.locator(".card-body")).to_have_attribute("aria-pressed", "true")
        page.get_by_role("button", name="Stop r1").click()  # a touch by mistake
        expect(card.get_by_text("Press longer")).to_be_visible()
        page.get_by_role("button", name="Stop r1").click(delay=HELD_MS)
        expect(card).to_have_attribute("data-stop", "stopped", timeout=SOON_MS)
        assert (robot.linear, robot.angular) == (0.0, 0.0)
        card.get_by_role("button", name="Resume r1").click()
        expect(card).to_have_attribute("data-stop", "stopped")
        card.get_by_role("button", name="Confirm: resume r1").click()
        expect(card).to_have_attribute("data-stop", "free", timeout=SOON_MS)

        # a STOP that does not get through is said to be unconfirmed, and is sent until it does
        assert opened.errors == []
        page.route("**/stop", lambda route: route.abort())
        page.get_by_role("button", name="Stop r1").focus()
        page.keyboard.press("Enter", delay=HELD_MS)
        expect(card).to_have_attribute("data-stop", "unconfirmed", timeout=SOON_MS)
        expect(page.locator(".notice-alarm")).to_contain_text("STOP for r1 is NOT confirmed")
        page.unroute("**/stop")
        expect(card).to_have_attribute("data-stop", "stopped", timeout=SOON_MS)
        expect(page.locator(".notice-alarm")).to_have_count(0)
        opened.errors.clear()  # the browser logs each request that was cut off
        card.get_by_role("button", name="Resume r1").click()
        card.get_by_role("button", name="Confirm: resume r1").click()
        expect(card).to_have_attribute("data-stop", "free", timeout=SOON_MS)

        # robots of a group are stopped in one action
        page.get_by_role("checkbox", name="r1 is in the group").check()
        page.get_by_role("button", name="Stop the group: r1").click(delay=HELD_MS)
        expect(card).to_have_attribute("data-stop", "stopped", timeout=SOON_MS)
        page.get_by_role("checkbox", name="r1 is in the group").uncheck()
        card.get_by_role("button", name="Resume r1").click()
        card.get_by_role("button", name="Confirm: resume r1").click()
        expect(card).to_have_attribute("data-stop", "free", timeout=SOON_MS)

        page.get_by_role("button", name="STOP ALL").click(delay=HELD_MS)
        expect(page.get_by_text("All stopped", exact=True)).to_be_visible(timeout=SOON_MS)
        # a hazard is written on the plan, at a point and over an area, read, and taken away
        plan = page.locator("#plan")
        page.get_by_role("button", name="Note", exact=True).click()
        page.get_by_label("What it says").fill("smell of gas")
        page.get_by_role("button", name="At a point…").click()
        plan.click(position={"x": 470, "y": 560})
        page.locator(".mark.note", has_text="smell of gas").click()
        expect(page.get_by_role("region", name="Hazard")).to_contain_text("By operator")
        page.get_by_role("region", name="Hazard").get_by_role("button", name="Remove").click()
        expect(page.locator(".mark.note")).to_have_count(0)
        page.get_by_role("button", name="Note", exact=True).click()
        page.get_by_role("button", name="✓ Searched").click()
        page.get_by_role("button", name="Over an area…").click()
        for x, y in ((420, 500), (520, 500), (520, 600)):
            plan.click(position={"x": x, "y": y})
        page.get_by_role("button", name="Close the area").click()
        expect(page.locator(".mark.note[data-kind=searched]")).to_be_visible(timeout=SOON_MS)

        # EVACUATE stands across the page until it is over, and says who has heard it
        page.get_by_role("button", name="EVACUATE").click(delay=HELD_MS)
        expect(page.locator(".evacuation")).to_contain_text("Everybody out, says operator")
        page.get_by_role("button", name="I have heard it").click()
        expect(page.locator(".evacuation")).to_contain_text("Heard by operator")
        page.get_by_role("button", name="EVACUATE is over").click(delay=HELD_MS)
        expect(page.locator(".evacuation")).to_have_count(0)
        assert robot.failure is None
        assert opened.errors == []

        # the robot falls silent, then the server ends: neither passes for live
        robot.stop()
        expect(mark).to_have_attribute("data-link", "late", timeout=SOON_MS)
        expect(card.locator(".stop-state")).to_have_text("Not heard")
        expect(card.locator(".reason")).to_have_text(
            re.compile("^Stood still when last heard, .* s ago: it had heard STOP")
        )
        serve.stop(host)
        expect(page.locator("#veil")).to_contain_text("STALE since", timeout=SOON_MS)
        expect(page.locator(".connection")).to_have_text("Stale")
    finally:
        robot.stop()


def test_the_3d_view_opens_beside_the_plan(opened: OpenPage, client: httpx.Client, host: str) -> None:
    page = opened.page
    create_mission(client)
    page.goto(f"http://{host}/console")
    expect(page.locator(".connection")).to_have_text("Live", timeout=SOON_MS)
    assert page.locator("iframe").count() == 0, "nothing of the 3D view is loaded before it is asked for"
    page.get_by_role("button", name="3D", exact=True).click()
    canvas = page.frame_locator("#scene-pane iframe").locator("canvas").first
    expect(canvas).to_be_visible(timeout=FIRST_MS)
    assert opened.errors == []


def test_a_phone_sees_stop_and_one_panel_at_a_time(browser: Browser, client: httpx.Client, host: str) -> None:
    create_mission(client)
    page = browser.new_page(viewport={"width": 360, "height": 740}, has_touch=True)
    try:
        page.goto(f"http://{host}/console")
        expect(page.get_by_text("No robot has been heard in this mission")).to_be_visible(timeout=SOON_MS)
        stop = page.get_by_role("button", name="STOP ALL").bounding_box()
        assert stop is not None
        assert stop["x"] + stop["width"] <= 360
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
        page.locator("#tabs").get_by_role("button", name="Alerts").tap()
        expect(page.locator("#events")).to_be_visible()
        expect(page.locator("#robots")).to_be_hidden()
    finally:
        page.close()
