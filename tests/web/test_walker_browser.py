"""The page itself, out of reach, leads a simulated walker to the victim: they know what it shows, no more."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from math import hypot
from typing import Any

import httpx
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from robots.sim.live import play
from robots.sim.simulation import Simulation
from robots.sim.walker import Advice, Walker
from server.app import create_app
from server.settings import Settings
from tests.server.test_walker_story import SCENARIO
from tests.web.conftest import Serve
from tests.web.field import keep

SOON_MS = 60_000
LEGS = """async (victims) => {
  const { all } = await import("/static/phone/kept.js");
  const { Roads } = await import("/static/phone/roads.js");
  const { routeTo } = await import("/static/phone/where.js");
  const [{ text }] = await all("pockets");
  const pocket = JSON.parse(text);
  const roads = new Roads(pocket);
  const legs = (tag, victim) => routeTo(pocket, roads, tag, `victim:${victim}`)?.legs.length ?? -1;
  return victims.flatMap((victim) => pocket.tags.map(({ tag_id }) => [legs(tag_id, victim), tag_id, victim]));
}"""


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Simulation, str, dict[str, Any]]]:
    """The world that a robot explored, the mission's address, and the file that a phone takes of it."""
    serve, simulations = Serve(), list[Simulation]()
    host = serve(create_app(Settings(data_dir=tmp_path_factory.mktemp("walk"), login="off", reply_s=60.0)))
    play(SCENARIO, f"http://{host}", "walked", speed=0.0, progress=simulations.append)
    with httpx.Client(base_url=f"http://{host}/api/v1/missions/walked", timeout=90) as api:
        while True:
            pocket = api.get("/pocket").raise_for_status().json()
            if pocket["ways"] and any(victim["ends"] for victim in pocket["victims"]):
                break
            time.sleep(0.2)
    yield simulations[0], f"http://{host}", pocket
    serve.close()


class PagePhone:
    """The phone in the walker's hand: they hold it to a tag and look at it."""

    def __init__(self, page: Page, home: str, victim: str) -> None:
        self.page, self.home, self.victim = page, home, victim
        self.legs = 0

    def __call__(self, tag_id: str) -> Advice | None:
        page = self.page
        page.goto(f"{self.home}/t/{tag_id}")
        expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
        guide = page.locator(".go")
        if not guide.count():
            page.get_by_role("button", name=f"Victim {self.victim}").click()
        arrow = guide.get_by_role("img").get_attribute("aria-label", timeout=SOON_MS)
        degrees = re.match(r"Arrow, (\d+) degrees", arrow or "")
        assert degrees, arrow
        following = guide.get_by_role("link")
        to = following.inner_text().removeprefix("I am at ") if following.count() else None
        self.legs += to is not None
        return Advice(float(degrees[1]), guide.locator("p.text").last.inner_text(), to)


def test_who_opens_a_cold_phone_without_signal_is_led_to_the_victim_they_chose(
    explored: tuple[Simulation, str, dict[str, Any]], context: BrowserContext
) -> None:
    simulation, home, pocket = explored
    page = context.new_page()
    page.goto(f"{home}/t/BASE?mission=walked")
    keep(page)
    victims = [victim["victim_id"] for victim in pocket["victims"] if victim["ends"]]
    legs = page.evaluate(LEGS, victims)
    count, start, victim_id = max(legs)
    assert count >= 2, legs
    page.close()
    context.set_offline(True)
    phone = PagePhone(context.new_page(), home, victim_id)
    tag = simulation.tags.named(start)
    walker = Walker(simulation.world, simulation.tags, simulation.victims, phone, (tag.x_m, tag.y_m), 1)
    ticks = 0
    while walker.advance():
        ticks += 1
        assert ticks < 9000, f"still walking after half an hour; read {walker.read}"
    chosen = next(victim for victim in pocket["victims"] if victim["victim_id"] == victim_id)
    far = {hypot(v.x_m - chosen["x_m"], v.y_m - chosen["y_m"]): v for v in simulation.victims}
    named = far[min(far)]  # whom the map means
    assert min(far) < 2.0
    assert walker.read[0] == start
    assert phone.legs  # who comes by a later tag of the way touches that one
    assert hypot(named.x_m - walker.x_m, named.y_m - walker.y_m) < 1.0, walker.read
