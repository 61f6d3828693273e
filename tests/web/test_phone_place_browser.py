"""Where the phone says it is and which way to go, in a real browser: compass, tag behind, radio nodes."""

from __future__ import annotations

import re
import time
from math import atan2, degrees, hypot, log10, radians

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.web.axe import SMALL
from tests.web.field import Field, keep

SOON_MS = 60_000
TURNED = """(alpha) => dispatchEvent(Object.assign(new Event("deviceorientationabsolute"), { alpha }))"""


def test_without_a_compass_the_tag_behind_leads_and_with_one_the_arrow_turns(
    field: Field, page: Page
) -> None:
    a = field.links[0][0]
    with field.api as api:
        tags = [tag["tag_id"] for tag in api.get("/tags").json()["tags"]]
        ways = {c: api.get("/routes", params={"from": a, "to": f"tag:{c}"}).json() for c in tags}
    c = next(c for c, way in ways.items() if len(way.get("legs", ())) > 1)
    page.goto(f"{field.home}/t/{a}")
    expect(page.get_by_text(f"You are at tag {a}")).to_be_visible(timeout=SOON_MS)
    goal = {"mission": "drill", "to": f"tag:{c}", "whole_m": 0}
    page.evaluate("(goal) => localStorage.setItem('waymark.target', JSON.stringify(goal))", goal)
    page.reload()
    guide = page.locator(".go")
    expect(guide).to_contain_text("The arrow points as on the plan below.", timeout=SOON_MS)
    following = guide.get_by_role("link")
    tag = following.inner_text().removeprefix("I am at ")
    following.click()
    expect(page.get_by_role("heading", level=1)).to_have_text(f"Tag {tag}")
    expect(guide).to_contain_text(
        re.compile(rf"(Keep {a} behind you|With {a} behind you, turn|Go back towards {a})")
    )
    assert page.evaluate(SMALL) == {"low": [], "small": [], "wide": 0}
    arrow, name = guide.locator("svg g"), guide.locator("svg")
    assert "from the plan’s north" in (name.get_attribute("aria-label") or "")
    page.evaluate(TURNED, 90)  # nobody has said how the plan lies: a compass is no help
    expect(guide).to_contain_text("behind you")
    with field.api as api:
        place = {"origin": {"lat_deg": 48.1, "lon_deg": 11.5}, "yaw_rad": radians(60.0)}
        api.put("/georeference", json=place).raise_for_status()
        while api.get("/pocket").json()["x_axis_deg"] is None:  # a pocket is packed once a second at most
            time.sleep(0.1)
        leg = api.get("/routes", params={"from": tag, "to": f"tag:{c}"}).json()["legs"][0]
        (x0, y0), (x1, y1) = leg["points_m"][:2]
        assert leg["bearing_deg"] == pytest.approx(
            (30.0 - degrees(atan2(y1 - y0, x1 - x0))) % 360.0, abs=0.01
        )
    page.reload()
    expect(name).to_have_attribute("aria-label", re.compile("degrees from north"), timeout=SOON_MS)
    page.evaluate(TURNED, 90)  # the phone's top points west
    expect(guide).to_contain_text("The compass shows magnetic north")
    turn = float(re.search(r"rotate\(([-\d.]+)", arrow.get_attribute("transform") or "")[1])
    assert abs(turn - (leg["bearing_deg"] - 270)) <= 0.5
    expect(guide).not_to_contain_text("behind you")
    with field.api as api:
        api.delete("/georeference").raise_for_status()


HEARS = """navigator.bluetooth = Object.assign(new EventTarget(), {
  async requestLEScan({ filters }) { this.prefix = filters[0].namePrefix; return { stop() {} }; },
  call(id, rssi) {
    this.dispatchEvent(Object.assign(new Event("advertisementreceived"), { name: this.prefix + id, rssi }));
  },
})"""


def test_a_phone_without_signal_finds_itself_by_the_nodes_it_hears(
    field: Field, context: BrowserContext
) -> None:
    """Signals as three nodes would send them to where it is; the browser's own radio is stubbed, no more."""
    context.add_init_script(
        f"Object.defineProperty(navigator, 'bluetooth', {{value: null, writable: true}}); {HEARS}"
    )
    page = context.new_page()
    page.goto(f"{field.home}/t")
    keep(page)
    page.reload()
    context.set_offline(True)
    with field.api as api:
        tags = {tag["tag_id"]: (tag["x_m"], tag["y_m"]) for tag in api.get("/tags").json()["tags"]}
        radio = api.get("/pocket").json()["radio"]
    near, *others = list(tags)[:4]
    page.get_by_role("button", name="Find me by radio nodes").click()
    expect(page.get_by_text("None is heard yet")).to_be_visible()

    def call(names: list[str], at: tuple[float, float]) -> None:
        for name in names:
            far = max(hypot(tags[name][0] - at[0], tags[name][1] - at[1]), 0.3)
            rssi = radio["power_at_1m_dbm"] - 10 * radio["path_loss_exponent"] * log10(far)
            for _ in range(10):
                page.evaluate("([id, rssi]) => navigator.bluetooth.call(id, rssi)", [name, rssi])

    call([near], tags[near])
    expect(page.get_by_role("status")).to_contain_text(f"from node {near}, in any direction", timeout=SOON_MS)
    call([near, *others], tags[near])
    expect(page.get_by_role("status")).not_to_contain_text("in any direction", timeout=SOON_MS)
    expect(page.locator("canvas.plan")).to_have_attribute("aria-label", re.compile("where this phone may be"))
    said = page.get_by_role("status").inner_text()
    found = re.search(r"(?:about (\d+) m [\w -]+ of|at) tag ([^ ,]+), give or take \d+ m", said)
    assert found, said
    away = hypot(tags[found[2]][0] - tags[near][0], tags[found[2]][1] - tags[near][1])
    assert away - float(found[1] or 0) < 3.5, said
    page.get_by_role("button", name="Stop listening").click()
    expect(page.get_by_role("button", name="Find me by radio nodes")).to_be_visible()
    context.set_offline(False)
