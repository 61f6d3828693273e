"""The best map in a real browser, on the real server: asked for, shown in place of the live one, left."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from robots.agent import RobotAgent, merge_commands
from robots.config import AgentConfig
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.sim.wire import observation_to_wire
from server.app import create_app
from server.settings import Settings
from tests.held import best_maps_held

pytestmark = pytest.mark.browser

MISSION = "drill"
AT = f"/api/v1/missions/{MISSION}"
SOON_MS = 60_000
SOLVED_MS = 120_000  # of low priority, on a machine that has other things to do
BATCHES, LATER = 60, 60
INK = "[...document.querySelectorAll('.leaflet-ink-pane canvas')].map((canvas) => canvas.toDataURL())"


@pytest.fixture(scope="module")
def wires() -> list[list[dict[str, Any]]]:
    """What a robot of the simulator observes in an office, batch by batch."""
    simulation = Simulation(ScenarioConfig(map="office:60", robots=1, seed=4, victims=2))
    agent = RobotAgent("r1", AgentConfig())
    found = []
    for _ in range(BATCHES + LATER):
        batch = simulation.advance()["r1"]
        found.append([observation_to_wire(observation) for observation in batch])
        simulation.apply({"r1": Order(merge_commands([agent.step(each) for each in batch]))})
    return found


@pytest.fixture
def app(tmp_path: Path) -> FastAPI:
    return create_app(Settings(data_dir=tmp_path, login="off", reply_s=60.0))


@pytest.fixture
def host(serve: Callable[[FastAPI], str], app: FastAPI) -> str:
    return serve(app)


@pytest.fixture
def client(host: str) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=f"http://{host}", timeout=90) as client:
        client.post("/api/v1/missions", json={"name": "Drill", "mission_id": MISSION}).raise_for_status()
        yield client


def send(client: httpx.Client, batches: list[list[dict[str, Any]]]) -> None:
    for observations in batches:
        client.post(f"{AT}/robots/r1/observations", json={"observations": observations}).raise_for_status()


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)], ids=["desk", "phone"])
def test_the_best_map_takes_the_live_ones_place_and_gives_it_back(
    browser: Browser, client: httpx.Client, host: str, app: FastAPI, wires: Any, width: int, height: int
) -> None:
    client.post(f"{AT}/robots", json={"robot_id": "r1"}).raise_for_status()
    send(client, wires[:BATCHES])
    page = browser.new_page(viewport={"width": width, "height": height}, has_touch=width < 900)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    try:
        page.goto(f"http://{host}/console")
        if width < 900:
            page.get_by_role("button", name="Map tools").click(timeout=SOON_MS)
        live, best = _switch(page)
        expect(live).to_have_attribute("aria-pressed", "true", timeout=SOON_MS)
        expect(page.locator(".mark.robot")).to_be_visible(timeout=SOON_MS)
        expect(page.locator("canvas.building")).to_be_visible(timeout=SOON_MS)
        for button in (live, best):
            box = button.bounding_box()
            assert box is not None
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= width
        before = _ink(page)

        # asked for by keyboard, and made: its picture and trails stand in place of the live ones
        best.focus()
        page.keyboard.press("Enter")
        expect(best).to_have_attribute("aria-pressed", "true")
        status = page.locator(".best-status")
        expect(status).to_contain_text("Solved", timeout=SOLVED_MS)
        expect(status).to_contain_text("All that robots have seen is in it.")
        made = client.get(f"{AT}/best-map").json()
        assert (made["state"], made["is_current"]) == ("ready", True)
        expect(page.locator("canvas.building")).to_have_count(1)
        page.wait_for_function(
            "width => document.querySelector('canvas.building')?.width === width", arg=made["map"]["width"]
        )
        expect(page.locator(".mark.robot")).to_have_count(0)
        page.wait_for_function(f"before => JSON.stringify({INK}) !== JSON.stringify(before)", arg=before)
        assert page.evaluate("document.documentElement.scrollWidth") <= width

        # the robot drives on: it is said how old this is, and solved again when asked
        send(client, wires[BATCHES:])
        expect(status).to_contain_text("stale", timeout=SOON_MS)
        expect(status).to_contain_text(re.compile(r"Robots have driven \d+(\.\d)? m since"))
        status.get_by_role("button", name="Solve again").click()
        expect(status).to_contain_text("All that robots have seen is in it.", timeout=SOLVED_MS)
        assert client.get(f"{AT}/best-map").json()["map"]["version"] > made["map"]["version"]

        # live is one click away, and B goes there and back
        live.click()
        expect(page.locator(".mark.robot")).to_be_visible()
        expect(status).to_have_count(0)
        page.keyboard.press("b")
        expect(status).to_be_visible()
        page.keyboard.press("b")
        expect(page.locator(".mark.robot")).to_be_visible()
        assert errors == []
    finally:
        page.close()


def test_there_being_none_is_said_and_a_failure_too(
    browser: Browser, client: httpx.Client, host: str, wires: Any
) -> None:
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    try:
        page.goto(f"http://{host}/console")
        live, best = _switch(page)
        best.click(timeout=SOON_MS)
        words = page.locator(".best-words")
        expect(words).to_contain_text("No robot has observed anything yet", timeout=SOON_MS)
        live.click()
        expect(words).to_have_count(0)

        client.post(f"{AT}/robots", json={"robot_id": "r1"}).raise_for_status()
        send(client, wires[:5])
        with best_maps_held() as held:
            best.click()
            pid = held.get(timeout=60.0)
        expect(words).to_contain_text("Solving", timeout=SOON_MS)
        os.kill(pid, signal.SIGKILL)
        expect(words).to_contain_text("Solving failed", timeout=SOON_MS)
        expect(words).to_contain_text("ended before it was done")
        words.get_by_role("button", name="Solve again").click()
        expect(page.locator(".best-status")).to_contain_text("Solved", timeout=SOLVED_MS)
    finally:
        page.close()


def _switch(page: Page) -> tuple[Any, Any]:
    group = page.get_by_role("group", name="Which map")
    return group.get_by_role("button", name="Live"), group.get_by_role("button", name="Best map")


def _ink(page: Page) -> list[str]:
    """What the canvases over the building hold."""
    found: list[str] = page.evaluate(INK)
    assert found
    return found
