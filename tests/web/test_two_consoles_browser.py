"""Two who lead one mission: what one does the other sees, also while a robot's agent hangs or dies."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, expect

from server.app import create_app
from server.settings import Settings
from tests.web.small_robot import MISSION, SmallRobot

pytestmark = pytest.mark.browser

SOON_MS = 60_000
FIRST_MS = 60_000  # the first observations may have to wait for the agent's kernels to compile
HELD_MS = 900


def test_what_one_does_the_other_sees_and_stop_needs_no_agent(
    browser: Browser, serve: Callable[[FastAPI], str], tmp_path: Path
) -> None:
    app = create_app(Settings(data_dir=tmp_path, login="off", reply_s=60.0))
    host = serve(app)
    leads = browser.new_page(viewport={"width": 1366, "height": 768})
    helps = browser.new_page(viewport={"width": 1280, "height": 800})
    with httpx.Client(base_url=f"http://{host}", timeout=90) as client:
        client.post("/api/v1/missions", json={"name": "Drill", "mission_id": MISSION}).raise_for_status()
        robot = SmallRobot(client, "r1")
        try:
            card, same_card = (page.locator(".robot-card[data-robot=r1]") for page in (leads, helps))
            for page in (leads, helps):
                page.goto(f"http://{host}/console")
                expect(page.locator(".robot-card")).to_have_attribute("data-link", "live", timeout=FIRST_MS)

            # STOP by one, with an agent that hangs: both see that the robot has heard it
            mission = app.state.missions.get(MISSION)
            pid = mission.roster.get("r1").host.pid
            os.kill(pid, signal.SIGSTOP)
            try:
                leads.get_by_role("button", name="Stop r1").click(delay=HELD_MS)
                for each in (card, same_card):
                    expect(each).to_have_attribute("data-stop", "stopped", timeout=SOON_MS)
                    known = "Stands still: it has heard STOP. Its agent is down, which STOP does not need."
                    expect(each.locator(".reason")).to_have_text(known, timeout=SOON_MS)
                assert (robot.linear, robot.angular) == (0.0, 0.0)
            finally:
                with suppress(ProcessLookupError):  # a supervisor that waited long enough has done so
                    os.kill(pid, signal.SIGKILL)

            # the agent is brought back, which is an alert that one takes note of for both
            restarted = re.compile("The agent of r1 was restarted")
            of_agent, same_alert = (
                page.locator(".alert-card", has_text=restarted) for page in (leads, helps)
            )
            for alert in (of_agent, same_alert):
                expect(alert).to_be_visible(timeout=SOON_MS)
            same_alert.get_by_role("button", name="Acknowledge").click()
            expect(of_agent).to_have_count(0, timeout=SOON_MS)  # noted, and over: the agent answers again
            card.get_by_role("button", name="Resume r1").click()
            card.get_by_role("button", name="Confirm: resume r1").click()
            expect(same_card).to_have_attribute("data-stop", "free", timeout=SOON_MS)

            # somebody calls MAYDAY: both consoles have it, over a reload too, until it is noted and over
            client.post(f"/api/v1/missions/{MISSION}/alerts/mayday", json={}).raise_for_status()
            called = re.compile("MAYDAY from operator")
            expect(leads.locator(".alert-card.alert-alarm", has_text=called)).to_be_visible(timeout=SOON_MS)
            leads.reload()
            expect(leads.locator(".alert-card.alert-alarm", has_text=called)).to_be_visible(timeout=SOON_MS)
            leads.get_by_role("button", name=re.compile("^Acknowledge: MAYDAY")).click()
            mayday = helps.locator(".alert-card", has_text=called)
            expect(mayday).to_contain_text("Noted by operator", timeout=SOON_MS)
            mayday.get_by_role("button", name="It is over").click()
            expect(leads.locator(".alert-card", has_text=called)).to_have_count(0, timeout=SOON_MS)
            assert robot.failure is None
        finally:
            robot.stop()
            for page in (leads, helps):
                page.close()
