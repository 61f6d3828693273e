"""The responder's phone in a real browser: at a tag that a robot left, led to the victim that it found."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from robots.sim.wire import observation_to_wire
from server.app import create_app
from server.settings import Settings

START = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.4, "sd_m": 0.05, "sd_rad": 0.01}
SOON_MS = 15_000


@pytest.fixture
def mission(serve: Any, tmp_path: Path, robot_log: Any) -> dict[str, Any]:
    """A mission in which a robot passed tags and saw a victim: its address, tags and victims."""
    host = serve(create_app(Settings(data_dir=tmp_path, login="off", reply_s=60.0)))
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        opened = client.post("/missions", json={"name": "Drill", "mission_id": "drill", "tag_key": ""})
        opened.raise_for_status()
        config = {"deployment": {"spacing_m": 2.0, "rate_per_m": 3.0}}
        words = {"robot_id": "r1", "config": config, "start_pose": START}
        client.post("/missions/drill/robots", json=words).raise_for_status()
        wires = [observation_to_wire(observation) for observation in robot_log.observations]
        for k in range(0, len(wires), 100):
            body = {"observations": wires[k : k + 100]}
            client.post("/missions/drill/robots/r1/observations", json=body).raise_for_status()
        for _ in range(900):
            victims = client.get("/missions/drill/victims").json()["victims"]
            found = client.get("/missions/drill/tags").json()
            if victims and len(found["links"]) > 1:
                break
            time.sleep(0.1)
    assert victims
    assert len(found["links"]) > 1
    return {"host": host, "links": found["links"], "victim": victims[0]["victim_id"]}


@pytest.fixture
def page(browser: Browser) -> Page:
    return browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True).new_page()


def test_a_responder_is_led_from_a_tag_to_the_victim_and_leaves_word(mission: Any, page: Page) -> None:
    home = f"http://{mission['host']}"
    tag = mission["links"][0][0]
    page.goto(f"{home}/t")
    page.get_by_label("The number on the tag").fill(f" {tag[:1]} {tag[1:]} ")
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name=f"Tag {tag}")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_text(f"You are at tag {tag}.")).to_be_visible()

    page.get_by_role("button", name=f"Victim {mission['victim']}").click()
    guide = page.locator(".go")
    expect(guide.locator(".number")).to_have_text(re.compile(r"\d+ m"), timeout=SOON_MS)
    for _ in range(12):  # tag by tag, each touched with the phone
        following = guide.get_by_role("link")
        if not following.count():
            break
        following.click()
        expect(page.get_by_role("heading", level=1)).not_to_have_text(f"Tag {tag}", timeout=SOON_MS)
        expect(guide.locator(".number")).to_be_visible(timeout=SOON_MS)
        tag = page.get_by_role("heading", level=1).inner_text().removeprefix("Tag ")
    expect(guide).to_contain_text("to the victim")
    expect(guide).to_contain_text(f"From tag {tag} go ")
    guide.get_by_role("button", name="Stop leading me").click()
    expect(guide).to_have_count(0)

    page.get_by_role("button", name="Leave word here").click()
    page.get_by_label("What is here").fill("stairs <b>broken</b>")
    page.get_by_role("button", name="Hazard").click()
    expect(page.get_by_text(f"Hazard left at tag {tag}.")).to_be_visible(timeout=SOON_MS)
    with httpx.Client(base_url=f"{home}/api/v1/missions/drill", timeout=30) as client:
        (note,) = client.get("/annotations").json()["annotations"]
        assert (note["kind"], note["tag_id"], note["text"]) == ("hazard", tag, "stairs <b>broken</b>")

        page.get_by_role("button", name="MAYDAY").click(delay=900)
        expect(page.get_by_text("MAYDAY was called")).to_be_visible(timeout=SOON_MS)
        (alert,) = [a for a in client.get("/alerts").json()["alerts"] if a["kind"] == "mayday"]
        assert alert["tag_id"] == tag
        client.post("/evacuation").raise_for_status()
        page.get_by_role("button", name="I have heard it").click(timeout=SOON_MS)
        expect(page.locator("#alarm").get_by_role("button")).to_have_count(0)
        assert [h["name"] for h in client.get("/evacuation").json()["acknowledged"]] == ["operator"]


def test_a_tag_that_nobody_knows_is_named(mission: Any, page: Page) -> None:
    page.goto(f"http://{mission['host']}/t/nowhere")
    expect(page.get_by_role("alert")).to_contain_text(
        "No mission here knows a tag 'nowhere'", timeout=SOON_MS
    )
    expect(page.get_by_label("The number on the tag")).to_be_visible()
