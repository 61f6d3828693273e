"""The page itself, out of reach, leads a simulated walker to the victim: they know what it shows, no more."""

from __future__ import annotations

import re
from math import hypot
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from robots.sim.starts import Victim
from robots.sim.tags import TagField
from robots.sim.walker import Advice, Walker
from robots.sim.world import WALL, World
from tests.web.field import Field, keep

SOON_MS = 60_000
CELL_M = 0.05
EDGE_M = 6.0
ROUTES = """async (victim) => {
  const { all } = await import("/static/phone/kept.js");
  const { Roads } = await import("/static/phone/roads.js");
  const { routeTo } = await import("/static/phone/where.js");
  const [{ text }] = await all("pockets");
  const pocket = JSON.parse(text);
  const roads = new Roads(pocket);
  const legs = (tag) => routeTo(pocket, roads, tag, `victim:${victim}`)?.legs.length ?? -1;
  return pocket.tags.map(({ tag_id }) => [tag_id, legs(tag_id)]);
}"""


def world_of(walls_m: np.ndarray) -> World:
    side = round(3 * EDGE_M / CELL_M)
    cells = np.zeros((side, side), np.uint8)
    for x0, y0, x1, y1 in walls_m:
        steps = 2 + int(2 * hypot(x1 - x0, y1 - y0) / CELL_M)
        columns = ((np.linspace(x0, x1, steps) + EDGE_M) / CELL_M).astype(int)
        rows = ((np.linspace(y0, y1, steps) + EDGE_M) / CELL_M).astype(int)
        cells[rows, columns] = WALL
    return World(cells, (-EDGE_M, -EDGE_M), CELL_M)


class PagePhone:
    """The phone in the walker's hand: they hold it to a tag and look at it."""

    def __init__(self, page: Page, field: Field) -> None:
        self.page, self.field = page, field
        self.legs = 0

    def __call__(self, tag_id: str) -> Advice | None:
        page = self.page
        page.goto(f"{self.field.home}/t/{tag_id}")
        expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
        guide = page.locator(".go")
        if not guide.count():
            page.get_by_role("button", name=f"Victim {self.field.victim}").click()
        arrow = guide.get_by_role("img").get_attribute("aria-label", timeout=SOON_MS)
        degrees = re.match(r"Arrow, (\d+) degrees", arrow or "")
        assert degrees, arrow
        following = guide.get_by_role("link")
        to = following.inner_text().removeprefix("I am at ") if following.count() else None
        self.legs += to is not None
        return Advice(float(degrees[1]), guide.locator("p.text").last.inner_text(), to)


@pytest.mark.parametrize("seed", range(2))
def test_who_opens_a_cold_phone_without_signal_is_led_to_the_victim_they_chose(
    field: Field, robot_log: Any, context: BrowserContext, seed: int
) -> None:
    page = context.new_page()
    page.goto(f"{field.home}/t/{field.links[0][0]}")
    keep(page)
    legs = dict(page.evaluate(ROUTES, field.victim))
    start = max(legs, key=lambda tag: (legs[tag], tag))
    assert legs[start] >= 2
    page.close()
    context.set_offline(True)
    tags = TagField(2048)
    for tag_id, place in robot_log.tags_m.items():
        tags.drop(tag_id, *place)
    victims = (Victim(field.victim, *robot_log.victim_m), Victim("another", -1.2, -3.5))
    phone = PagePhone(context.new_page(), field)
    walker = Walker(world_of(robot_log.walls_m), tags, victims, phone, robot_log.tags_m[start], seed)
    ticks = 0
    while walker.advance():
        ticks += 1
        assert ticks < 9000, f"still walking after half an hour; read {walker.read}"
    assert walker.read[0] == start
    assert phone.legs >= 2
    off_m = hypot(robot_log.victim_m[0] - walker.x_m, robot_log.victim_m[1] - walker.y_m)
    assert off_m < 1.0, walker.read
