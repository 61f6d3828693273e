"""Tags of another mission, links and chips that are none of ours, what strangers wrote: in plain words."""

from __future__ import annotations

import time
from uuid import uuid4

import httpx
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from server.benchmarks.nfc_stub import NFC
from tests.web.axe import SMALL
from tests.web.field import CONFIG, START, Field, keep

SOON_MS = 60_000
TURNED, HEAPED = "\u202egnidaelsim\u202c", "e" + "\u0301" * 40
HOSTILE = f"<img src=x onerror=alert(1)> {TURNED} {'A' * 300} {HEAPED}\n\nMAYDAY was called"
MARKED = "() => document.querySelectorAll('main img, main script, main b').length"


@pytest.fixture(scope="module")
def two(field: Field) -> Field:
    """The mission, and a later one with the tags X1, X2 and one of the same name as our first."""
    with httpx.Client(base_url=f"{field.home}/api/v1", timeout=90) as client:
        words = {"name": "Other place", "mission_id": "other", "tag_key": ""}
        client.post("/missions", json=words).raise_for_status()
        words = {"robot_id": "r9", "config": CONFIG, "start_pose": START}
        client.post("/missions/other/robots", json=words).raise_for_status()
        step = {"kind": "displacement", "dy_m": 0.0, "dtheta_rad": 0.0}
        for seq, tag in enumerate(("X1", None, "X2", None, field.links[0][0])):
            said = {"seq": seq, "stamp_s": float(seq), "odometry": step | {"dx_m": 1.0 if seq else 0.0}}
            said["tag_sightings"] = [{"tag_id": tag}] if tag else []
            body = {"observations": [said]}
            client.post("/missions/other/robots/r9/observations", json=body).raise_for_status()
        while len(client.get("/missions/other/tags").json()["tags"]) < 3:
            time.sleep(0.1)
    return field


@pytest.fixture
def page(context: BrowserContext) -> Page:
    context.add_init_script(NFC)
    return context.new_page()


def at(page: Page, address: str) -> None:
    page.goto(address)
    expect(page.get_by_role("button", name="Leave word here")).to_be_visible(timeout=SOON_MS)


def test_a_tag_of_two_missions_is_of_the_one_that_the_phone_is_in(two: Field, page: Page) -> None:
    first, second = two.links[0]
    at(page, f"{two.home}/t/{second}")  # ours alone has it
    keep(page)
    at(page, f"{two.home}/t/{first}")  # the server would say: the later mission
    expect(page.get_by_text("Drill", exact=True)).to_be_visible()
    expect(page.get_by_role("alert")).to_have_count(0)
    page.get_by_label("The number on the tag").fill("X1")
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name="Tag X1")).to_be_visible(timeout=SOON_MS)
    told = page.get_by_role("alert").filter(has_text="this tag is of another mission, Other place.")
    expect(told).to_contain_text("The one you read before is of Drill.", timeout=SOON_MS)
    at(page, f"{two.home}/t/{first}?mission=drill")  # whoever made the link knew
    expect(page.get_by_role("alert")).to_contain_text("is of another mission, Drill.", timeout=SOON_MS)


def test_links_that_lead_nowhere_say_what_is_wrong_with_them(two: Field, page: Page) -> None:
    tag = two.links[0][0]
    page.goto(f"{two.home}/t/{tag}?mission=nowhere")
    expect(page.get_by_role("alert")).to_have_text(
        f"That link is of a mission nowhere, which is not here or has no tag {tag}."
        " Type the number on the tag.",
        timeout=SOON_MS,
    )
    page.get_by_label("The number on the tag").fill(tag)
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name=f"Tag {tag}")).to_be_visible(timeout=SOON_MS)
    page.goto(f"{two.home}/t/%E0%A4%A")
    expect(page.get_by_role("alert")).to_contain_text("That link is damaged: %E0%A4%A is no tag.")


def test_of_chips_that_are_not_ours_the_last_counts(two: Field, page: Page) -> None:
    page.goto(f"{two.home}/t")
    page.get_by_role("button", name="Touch tags with this phone").click(timeout=SOON_MS)
    told = page.locator("main").get_by_role("alert")
    for script, words in (
        ("touchChip('https://usar.example/t/A4', null)", "this label is for another server, usar.example."),
        ("touchChip('https://shop.example/offer', null)", "That chip is no tag of Waymark."),
        ("touchChip(null, null)", "That chip is empty"),
        ("touchChip('https://usar.example/t/A4', null)", "this label is for another server, usar.example."),
        ("nfc.onreadingerror()", "That chip could not be read."),
    ):
        page.evaluate(script)
        expect(told).to_have_count(1)
        expect(told).to_contain_text(words)


def test_what_strangers_write_neither_turns_nor_covers_nor_moves_anything(two: Field, page: Page) -> None:
    tag, now = two.links[0][0], time.time()
    with two.api as api:
        for kind in ("hazard", "exit", "note"):
            said = {"kind": "note", "note": kind, "text": HOSTILE, "tag_id": tag}
            said |= {"phone_unix_s": now, "sent_phone_unix_s": now}
            api.put(f"/reports/{uuid4()}", json=said).raise_for_status()
        while len(api.get("/pocket").json()["notes"]) < 3:
            time.sleep(0.1)
    at(page, f"{two.home}/t/{tag}?mission=drill")
    page.get_by_role("button", name=f"Victim {two.victim}").click()
    guide = page.locator(".go")
    expect(guide).to_contain_text("Take care: <img src=x onerror=alert(1)> gnidaelsim AAA")
    text = guide.inner_text()
    assert "\u202e" not in text
    assert text.count("\u0301") <= 2
    assert page.evaluate(MARKED) == 0
    assert page.evaluate(SMALL) == {"low": [], "small": [], "wide": 0}
    stop = page.get_by_role("button", name="Stop leading me").bounding_box()
    assert stop is not None
    assert stop["x"] + stop["width"] <= 390
