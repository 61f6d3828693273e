"""The past in a real browser, on the real server: scrub back, jump, play, STOP meanwhile, return."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.small_robot import MISSION, SmallRobot

pytestmark = pytest.mark.browser

SOON_MS = 60_000
AT = f"/api/v1/missions/{MISSION}"
KNOWN = """() => [...document.querySelectorAll('canvas.building')].map((canvas) => {
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let known = 0;
  for (let at = 3; at < data.length; at += 4) known += data[at] > 128;
  return known;
})"""

EXPLORED = """() => Number([...document.querySelectorAll('.bar-figure')]
  .find((figure) => figure.textContent.includes('Explored')).querySelector('dd').textContent.split(' ')[0])"""


@pytest.fixture
def drill(serve: Callable[[FastAPI], str], tmp_path: Path) -> Iterator[tuple[httpx.Client, float]]:
    """A mission where a robot drove and saw a victim, a person told of gas, and a moment before that."""
    host = serve(create_app(Settings(data_dir=tmp_path, login="off", reply_s=60.0)))
    with httpx.Client(base_url=f"http://{host}", timeout=90) as client:
        client.post("/api/v1/missions", json={"name": "Drill", "mission_id": MISSION}).raise_for_status()
        robot = SmallRobot(client, "r1")
        eventually(lambda: client.get(f"{AT}/map").is_success and _driven_m(client) > 0.3)
        moment = time.time() + 1.0
        eventually(lambda: client.get(f"{AT}/victims").json()["victims"] and _driven_m(client) > 2.0)
        words = {"kind": "hazard", "text": "gas", "x_m": 1.0, "y_m": 1.0}
        note = f"{AT}/annotations/5b0c3f2e-9d2e-4c2f-8a43-000000000001"
        client.put(note, json=words).raise_for_status()
        eventually(lambda: time.time() > moment + 8)  # a map comes into the past every five seconds
        robot.stop()
        assert robot.failure is None
        yield client, moment


def eventually(condition: Callable[[], object]) -> None:
    deadline = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.2)


def _driven_m(client: httpx.Client) -> float:
    state = client.get(f"{AT}/robots/r1").json()["state"]
    return 0.0 if state is None else float(state["distance_m"])


def scrub(page: Page, share: float) -> None:
    box = page.locator("#time input").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 8 + share * (box["width"] - 16), box["y"] + box["height"] / 2)


def test_scrub_back_and_return(browser: Browser, drill: tuple[httpx.Client, float]) -> None:
    client, moment = drill
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(str(client.base_url.join("/console")))
    banner, robot, note = (
        page.locator(".past-banner"),
        page.locator(".mark.robot"),
        page.locator(".mark.note"),
    )
    card = page.locator('.robot-card[data-robot="r1"]')
    expect(page.locator("#time input")).to_be_visible(timeout=SOON_MS)
    expect(note).to_be_visible(timeout=SOON_MS)
    eventually(lambda: any(page.evaluate(KNOWN)))
    (now_known,) = page.evaluate(KNOWN)
    eventually(lambda: page.evaluate(EXPLORED) > 0)
    now_explored = page.evaluate(EXPLORED)
    now_driven = card.locator(".figure", has_text="Driven").locator(".figure-value").inner_text()
    card.locator(".card-body").click()
    expect(card.get_by_role("button", name="Hold")).to_be_visible()

    index = client.get(f"{AT}/history").json()
    whole_s = index["ends_unix_s"] - index["begins_unix_s"]
    scrub(
        page, (moment - index["begins_unix_s"]) / whole_s
    )  # before the note: fewer walls, an earlier pose, no orders
    expect(banner).to_contain_text(re.compile(r"You look at \d\d:\d\d:\d\d, \d+ s ago; orders are off"))
    expect(note).to_have_count(0)
    expect(card.get_by_role("button", name="Hold")).to_be_disabled()
    expect(card.locator(".figure", has_text="Driven")).not_to_contain_text(now_driven)
    eventually(lambda: [known < now_known for known in page.evaluate(KNOWN)] == [True])
    assert page.evaluate(EXPLORED) < now_explored
    expect(robot).to_be_visible()

    page.keyboard.press("[")
    before = banner.inner_text()
    page.keyboard.press("]")
    expect(banner).not_to_have_text(before)
    jumped = [mark.get_attribute("class") for mark in page.locator(".time-mark").all()]
    assert "time-mark victim" in jumped
    page.locator("#time input").focus()
    page.keyboard.press("Home")
    expect(robot).to_have_count(0)
    page.locator("#time select").select_option("10")
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=SOON_MS)  # it came to the end
    expect(note).to_be_visible()

    page.locator(".victim-card .card-body").first.click()
    page.keyboard.press("c")  # confirms a victim, but not now
    expect(page.locator(".notice")).to_contain_text("You look at the past. Go back to live first.")
    assert client.get(f"{AT}/victims").json()["victims"][0]["status"] == "suspected"

    stop = page.get_by_role("button", name="STOP ALL").bounding_box()
    assert stop is not None
    page.mouse.move(stop["x"] + 20, stop["y"] + 20)
    page.mouse.down()
    expect(page.locator(".stop-all-state")).to_be_visible(timeout=SOON_MS)
    page.mouse.up()
    assert client.get(f"{AT}/robots/r1").json()["stopped"]
    page.keyboard.press("Escape")
    page.keyboard.press("l")
    expect(banner).to_have_count(0)
    expect(card).to_have_attribute("data-stop", re.compile("ordered|braking|stopped"))
    eventually(lambda: page.evaluate(KNOWN) == [now_known])
    assert errors == []
    page.close()
