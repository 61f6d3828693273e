"""The console draws the markings that the report draws, stroke by stroke, in every state."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import httpx
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.benchmarks.browser import OWN_MODULE
from server.markings.victims import victim_markings, victim_words
from server.markings.worksites import worksite_markings
from server.settings import Settings
from tests.server.markings.states import sectors

pytestmark = pytest.mark.browser
SOON_MS = 60_000
DRAW = """async (told) => {
  const own = OWN;
  const [{ victimMarkings, markingWords }, { worksiteMarkings }] =
    await Promise.all([own("/static/console/markings.js"), own("/static/console/worksite_marks.js")]);
  return told.map(([sector, victims]) =>
    [worksiteMarkings(sector, victims), victims.map(victimMarkings), victims.map(markingWords)]);
}""".replace("OWN", OWN_MODULE)


def some_states(n: int) -> list[Any]:
    found: list[Any] = []

    @settings(max_examples=n, database=None, phases=[Phase.generate], derandomize=True,
              suppress_health_check=list(HealthCheck), deadline=None)  # fmt: skip
    @given(sectors())
    def gather(told: Any) -> None:
        found.append(told)

    gather()
    return found


def plain(markings: Any) -> list[Any]:
    return [{**asdict(each), "shapes": list(each.shapes)} for each in markings]


def test_console_and_report_draw_the_same_and_a_worksite_is_marked(
    browser: Browser, serve: Any, tmp_path: Any
) -> None:
    host = serve(create_app(Settings(data_dir=tmp_path, login="off")))
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        client.post("/missions", json={"name": "Mine"}).raise_for_status()
        area = [[-2.0, -2.0], [4.0, -2.0], [4.0, 3.0], [-2.0, 3.0]]
        sector = "/missions/mine/sectors/5e0f6c1e-0000-4000-8000-000000000001"
        client.put(sector, json={"name": "B2", "area_m": area}).raise_for_status()
        page = browser.new_page(viewport={"width": 1366, "height": 768})
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(f"http://{host}/console")
        told = some_states(150)
        assert any(each[0]["worksite"] and each[0]["worksite"]["is_complete"] for each in told)
        drawn = page.evaluate(DRAW, told)
        for (place, there), (worksite, marked, words) in zip(told, drawn, strict=True):
            assert worksite == plain(worksite_markings(place, there))
            assert marked == [plain(victim_markings(victim)) for victim in there]
            assert words == [victim_words(victim) for victim in there]
        mark_a_worksite(page)
        kept = client.get("/missions/mine/sectors").json()["sectors"][0]["worksite"]
        assert (kept["worksite_id"], kept["triage"], kept["is_complete"]) == ("AUS01-0102", "C", True)
        report = client.get("/missions/mine/report.html").text
        assert "INSARAG 2027, worksite" in report
        assert "&lt;B&gt;PIPE&lt;/B&gt;" in report
        assert "rapid clearance: deceased only" in report
        assert report.count("Rapid clearance") == 4  # both diamonds, each with its name
        page.close()
        assert errors == []


def mark_a_worksite(page: Page) -> None:
    page.get_by_role("button", name="Sectors").click(timeout=SOON_MS)
    panel = page.locator(".sectors")
    panel.locator(".sector-list button").click(timeout=SOON_MS)
    panel.get_by_role("button", name="Make it a worksite").click()
    marking = panel.get_by_role("img", name="INSARAG 2020, worksite")
    expect(marking).to_contain_text("B-1", timeout=SOON_MS)
    panel.get_by_label("Hazards").fill("gas <b>pipe</b>")
    panel.get_by_label("Hazards").press("Tab")
    expect(marking).to_contain_text("GAS <B>PIPE</B>", timeout=SOON_MS)
    panel.get_by_label("Triage of the worksite").select_option("C")
    panel.get_by_label("Team", exact=True).fill("AUS01")
    panel.get_by_role("button", name="The team goes in").click()
    search = panel.get_by_role("img", name="FEMA search: AUS01 is inside")
    expect(search.locator("path")).to_have_count(1, timeout=SOON_MS)
    done = panel.get_by_label("No more work is needed here")
    expect(done).to_be_disabled()
    panel.get_by_label("Floors and quadrants done").fill("Ground Floor")
    panel.get_by_role("button", name="Out, all searched").click()
    search = panel.get_by_role("img", name="FEMA search: AUS01 has searched all, nobody still inside")
    expect(search.locator("path")).to_have_count(3, timeout=SOON_MS)  # the cross, and the box of parts
    expect(marking).to_contain_text("AUS-01 ASR3")
    done.check()
    expect(panel.get_by_role("img", name="no more work needed")).to_be_visible(timeout=SOON_MS)
    panel.get_by_label("Worksite", exact=True).fill("AUS01-0102")
    panel.get_by_label("Worksite", exact=True).press("Tab")
    marking = panel.get_by_role("img", name="INSARAG 2027, worksite")
    expect(marking).to_contain_text("AUS01 ASR3", timeout=SOON_MS)

    # how safe the structure is, and, once all is searched, that only deceased are left, then nobody
    panel.get_by_label("Team", exact=True).fill("USA02")
    panel.get_by_label("Structure").select_option("high")
    panel.get_by_label("Safest entry").select_option("left")
    panel.get_by_role("button", name="Mark how safe it is").click()
    box = panel.get_by_role("img", name="USA02 rates the structure a high risk, safest entry left")
    expect(box.locator("path")).to_have_count(4, timeout=SOON_MS)
    for letter in ("D", "C"):
        panel.get_by_role("button", name=f"{letter}: ").click()
        expect(panel.get_by_role("img", name="Rapid clearance").last).to_contain_text(letter, timeout=SOON_MS)
    expect(panel.get_by_role("img", name="Rapid clearance")).to_have_count(2)
