"""The page of all missions, a mission's states in the console, and photos, in a real browser."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from PIL import Image
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings

pytestmark = pytest.mark.browser
SOON_MS = 60_000


@pytest.fixture
def host(serve: Callable[[FastAPI], str], tmp_path: Path) -> str:
    return serve(create_app(Settings(data_dir=tmp_path, login="off")))


@pytest.fixture
def client(host: str) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        yield client


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    yield page
    page.close()
    assert errors == []


def photo() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (400, 300), "teal").save(file, "PNG")
    return file.getvalue()


def test_a_mission_is_made_led_closed_found_and_compared(page: Page, host: str, client: httpx.Client) -> None:
    page.goto(f"http://{host}/missions")
    expect(page.get_by_text("No mission yet.")).to_be_visible(timeout=SOON_MS)
    for name in ("North <wing>", "South wing"):
        page.get_by_label("Name").fill(name)
        page.get_by_label("As a draft").check()
        page.get_by_label("Name").press("Enter")
        expect(page.get_by_role("link", name=name)).to_be_visible(timeout=SOON_MS)
    north = page.locator("tr", has_text="North")
    for step, state in (
        ("Start the mission", "Running"),
        ("Pause the mission", "Paused"),
        ("Close the mission", "Closed"),
    ):
        north.get_by_role("button", name=step).press("Enter")
        expect(north.locator(".mission-state")).to_have_text(state, timeout=SOON_MS)
    north.get_by_role("button", name="Archive").click()
    expect(north).to_have_count(0, timeout=SOON_MS)
    page.get_by_label("Show archived").check()
    page.get_by_label("Search").fill("north")
    expect(page.locator("tbody tr")).to_have_count(1)
    page.get_by_label("Search").fill("nowhere")
    expect(page.get_by_text("None of 2 missions fits")).to_be_visible()
    page.get_by_label("Search").fill("")
    page.get_by_label("Compare North <wing>").check()
    page.get_by_label("Compare South wing").check()
    page.get_by_role("button", name="Compare 2").click()
    expect(page.locator("#comparison tbody tr").first).to_contain_text("Archived", timeout=SOON_MS)
    page.reload()
    expect(page.locator("#comparison")).to_be_visible(timeout=SOON_MS)


def test_the_list_says_when_the_server_is_away_and_when_a_step_is_refused(
    page: Page, host: str, client: httpx.Client
) -> None:
    client.post("/missions", json={"name": "Mine"}).raise_for_status()
    page.goto(f"http://{host}/missions")
    row = page.locator("tr", has_text="Mine")
    expect(row).to_be_visible(timeout=SOON_MS)
    page.route(
        "**/api/v1/missions/mine/pause",
        lambda route: route.fulfill(
            status=403,
            json={"error": {"code": "role_too_low", "message": "Ask a commander to do it.", "field": None}},
        ),
    )
    row.get_by_role("button", name="Pause the mission").click()
    expect(page.get_by_role("alert")).to_have_text("Ask a commander to do it.")
    page.route("**/api/v1/missions", lambda route: route.abort())
    expect(page.get_by_text("What you see is the last that was known.")).to_be_visible(timeout=SOON_MS)
    expect(row).to_be_visible()
    page.reload()
    expect(page.get_by_text("The missions cannot be shown")).to_be_visible(timeout=SOON_MS)


def test_the_console_says_how_the_mission_stands_and_a_closed_one_is_read_only(
    page: Page, host: str, client: httpx.Client
) -> None:
    client.post("/missions", json={"name": "Mine", "state": "draft"}).raise_for_status()
    page.goto(f"http://{host}/console")
    banner = page.locator(".mission-banner")
    expect(banner).to_contain_text("Draft", timeout=SOON_MS)
    banner.get_by_role("button", name="Start the mission").click()
    expect(banner).to_have_count(0, timeout=SOON_MS)
    client.post("/missions/mine/pause").raise_for_status()
    expect(banner).to_contain_text("All robots stand still", timeout=SOON_MS)
    expect(page.get_by_role("button", name="Note")).to_be_enabled()
    page.locator(".mission-menu summary").click()
    card = page.locator(".mission-menu .pop-card").bounding_box()
    assert card is not None
    assert card["x"] >= 0  # nothing of it lies beyond the edge of the page
    page.get_by_role("button", name="Close the mission").click()
    expect(banner).to_contain_text("nothing in it changes any more", timeout=SOON_MS)
    expect(page.get_by_role("button", name="Note")).to_be_disabled()


def test_a_photo_is_left_at_a_note_seen_large_and_removed(
    page: Page, host: str, client: httpx.Client
) -> None:
    client.post("/missions", json={"name": "Mine"}).raise_for_status()
    note = "/missions/mine/annotations/00000000-0000-4000-8000-000000000001"
    client.put(note, json={"kind": "hazard", "text": "gas", "x_m": 1.0, "y_m": 2.0}).raise_for_status()
    page.goto(f"http://{host}/console")
    page.locator(".mark.note").focus(timeout=SOON_MS)
    page.keyboard.press("Enter")
    file = page.locator(".tag-card input[type=file]")
    file.set_input_files({"name": "x.png", "mimeType": "image/png", "buffer": b"no photo"})
    expect(page.get_by_text("The photo was not kept.")).to_be_visible(timeout=SOON_MS)
    file.set_input_files({"name": "x.png", "mimeType": "image/png", "buffer": photo()})
    small = page.locator(".tag-card .photo img")
    expect(small).to_be_visible(timeout=SOON_MS)
    expect(page.locator(".mark.photo-mark")).to_be_visible()
    page.locator(".tag-card .photo").press("Enter")
    large = page.locator("dialog.viewer img")
    expect(large).to_be_visible(timeout=SOON_MS)
    assert large.evaluate("image => image.decode().then(() => image.naturalWidth)") == 400
    page.keyboard.press("Escape")
    expect(large).to_have_count(0)
    expect(page.locator(".tag-card")).to_be_visible()  # Escape closed the photo alone
    page.locator(".mark.photo-mark").click()
    page.locator("dialog.viewer").get_by_role("button", name="Remove").click()
    expect(small).to_have_count(0, timeout=SOON_MS)
