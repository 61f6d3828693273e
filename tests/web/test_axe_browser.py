"""Every page in every state, as axe-core and a keyboard find it."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from robots.sim.wire import observation_to_wire
from server.app import create_app
from server.settings import Settings
from tests.web.axe import Audit

pytestmark = pytest.mark.browser
SOON_MS = 15_000
START = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.4, "sd_m": 0.05, "sd_rad": 0.01}


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_context(viewport={"width": 1366, "height": 768}).new_page()
    yield page
    page.context.close()


@pytest.fixture
def link(serve: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The link of the first start."""
    host = serve(create_app(Settings(data_dir=tmp_path, login="on", reply_s=60.0)))
    out = ""
    while "/join#" not in out:
        out += capsys.readouterr().out
        time.sleep(0.05)
    return f"http://{host}" + re.search(r"http://[^/]+(/join#\S+)", out)[1]  # type: ignore[index]


def _drive(page: Page, home: str, robot_log: Any) -> dict[str, Any]:
    """Have a robot pass tags and see a victim; return the victim and a tag."""
    post = page.request.post
    api = f"{home}/api/v1/missions"
    origin = {"Origin": home}
    assert post(api, data={"name": "Drill", "mission_id": "drill", "tag_key": ""}, headers=origin).ok
    robot = {"robot_id": "r1", "config": {"deployment": {"spacing_m": 2.0}}, "start_pose": START}
    assert post(f"{api}/drill/robots", data=robot, headers=origin).ok
    wires = [observation_to_wire(observation) for observation in robot_log.observations]
    for k in range(0, len(wires), 100):
        body = {"observations": wires[k : k + 100]}
        assert post(f"{api}/drill/robots/r1/observations", data=body, headers=origin, timeout=90_000).ok
    for _ in range(900):
        victims = page.request.get(f"{api}/drill/victims").json()["victims"]
        tags = page.request.get(f"{api}/drill/tags").json()["tags"]
        if victims and tags:
            return {"victim": victims[0]["victim_id"], "tag": tags[0]["tag_id"]}
        time.sleep(0.1)
    raise AssertionError("the robot's log shows no victim")


def test_every_page_and_state_has_no_violation(link: str, page: Page, robot_log: Any) -> None:
    home = link.split("/join")[0]
    audit = Audit(page)
    page.goto(f"{home}/login")
    expect(page.get_by_role("button", name="Log in")).to_be_visible()
    audit.look("login")
    page.goto(link)
    audit.look("join")
    page.get_by_label("Your name").fill("Ada")
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Join").click()
    expect(page.get_by_text("No mission yet")).to_be_visible(timeout=SOON_MS)
    audit.look("console without a mission")

    seen = _drive(page, home, robot_log)
    expect(page.locator(".victim-card")).to_be_visible(timeout=SOON_MS)
    audit.look("console with a mission")
    page.get_by_label("Logged in as Ada").click()
    audit.look("console, account")
    page.get_by_label("Look of this page").click()
    audit.look("console, look")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Layers").click()
    page.locator(".robot-card .card-body").click()
    audit.look("console, robot and layers")
    page.get_by_role("button", name="Note", exact=True).click()
    page.keyboard.press("j")
    expect(page.locator(".case")).to_be_visible()
    audit.look("console, victim and note")
    page.keyboard.press("b")
    audit.look("console, best map")
    page.keyboard.press("b")

    page.goto(f"{home}/people")
    page.get_by_label("What it is for").fill("red rover")
    page.get_by_role("button", name="Make a token").click()
    expect(page.locator(".secret")).to_be_visible()
    audit.look("people")
    page.goto(f"{home}/t/{seen['tag']}")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    audit.look("phone at a tag")
    page.get_by_role("button", name=f"Victim {seen['victim']}").click()
    expect(page.locator(".go .number")).to_be_visible(timeout=SOON_MS)
    audit.look("phone, led to a victim")
    assert not audit.found, "\n".join(audit.found)
