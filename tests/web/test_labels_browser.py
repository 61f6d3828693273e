"""Names on the plan: none covers another, what matters most goes first, and none flickers."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.conftest import Serve

pytestmark = pytest.mark.browser
SOON_MS = 60_000

# a crowd of names that move as robots do: every frame a few pixels, with noise
CROWD = """async ({ seed, count, width, frames, step }) => {
  const { LabelPlaces } = await import("/static/console/label_places.js");
  let state = seed;
  const random = () => ((state = (1103515245 * state + 12345) % 2147483648) / 2147483648);
  const places = new LabelPlaces();
  const sides = ["s", "n", "e", "w", "se", "sw", "ne", "nw"];
  const wishes = Array.from({ length: count }, (_, k) => ({
    key: `k${k}`, rank: Math.floor(7 * random()), x: width * random(), y: 500 * random(),
    width: 20 + 80 * random(), height: 16, gap: 4 + 14 * random(), sides, isForced: false, isBold: false }));
  wishes.forEach((wish) => (wish.isBold = wish.rank <= 3));
  const view = { left: 0, top: 0, right: width, bottom: 500 };
  const told = [];
  for (let frame = 0; frame < frames; frame += 1) {
    for (const wish of wishes) {
      wish.x += step * (random() - 0.5);
      wish.y += step * (random() - 0.5);
    }
    const blocks = wishes.map(({ key, x, y, gap }) => ({ key, x, y, half: 0.7 * gap }));
    const placed = [...places.arrange(wishes, blocks, view)].map(([key, { dx, dy, side }]) => {
      const { rank, x, y, width, height } = wishes.find((wish) => wish.key === key);
      const [left, top] = [x + dx - width / 2, y + dy - height / 2];
      return { key, rank, side, left, right: left + width, top, bottom: top + height };
    });
    told.push(placed);
  }
  const important = new Set(wishes.filter(({ rank }) => rank <= 2).map(({ key }) => key));
  const alone = new LabelPlaces().arrange(wishes.filter(({ key }) => important.has(key)), [], view);
  const among = new LabelPlaces().arrange(wishes, [], view);
  const same = [...alone].every(([key, { dx, dy }]) => among.get(key)?.dx === dx && among.get(key)?.dy === dy)
    && [...among.keys()].filter((key) => important.has(key)).length === alone.size;
  const wanted = wishes.map((wish) => ({ ...wish, isForced: true }));
  const forced = new LabelPlaces().arrange(wanted, [], view).size;
  return { told, same, forced };
}"""


def _overlap_px(a: dict[str, Any], b: dict[str, Any]) -> float:
    """By how much two boxes cover each other along the axis where that is less."""
    along_x = min(a["right"], b["right"]) - max(a["left"], b["left"])
    along_y = min(a["bottom"], b["bottom"]) - max(a["top"], b["top"])
    return float(min(along_x, along_y))


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A mission in which people have written a lot on a small spot."""
    serve = Serve()
    host = serve(create_app(Settings(data_dir=tmp_path_factory.mktemp("names"), login="off")))
    with httpx.Client(base_url=f"http://{host}", timeout=90) as client:
        client.post("/api/v1/missions", json={"name": "Drill", "mission_id": "drill"}).raise_for_status()
        for k in range(30):
            kind = "hazard" if k == 14 else "note"
            note = {"kind": kind, "text": f"Word {k:02d}", "x_m": 1.2 * (k % 6), "y_m": 1.2 * (k // 6)}
            path = f"/api/v1/missions/drill/annotations/00000000-0000-4000-8000-{k:012d}"
            client.put(path, json=note).raise_for_status()
    yield f"http://{host}"
    serve.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_context(viewport={"width": 1366, "height": 768}).new_page()
    yield page
    page.context.close()


@pytest.mark.parametrize(("seed", "count"), [(1, 30), (2, 120), (3, 300)])
def test_no_name_covers_another_and_what_matters_goes_first(
    home: str, page: Page, seed: int, count: int
) -> None:
    page.goto(f"{home}/login")
    crowd = page.evaluate(CROWD, {"seed": seed, "count": count, "width": 900, "frames": 25, "step": 8})
    for names in crowd["told"]:
        assert names
        for k, name in enumerate(names):
            assert all(_overlap_px(name, other) <= 3.0 for other in names[:k])
        # a name that may not cover marks stays in what is seen
        assert all(name["left"] >= -3 and name["right"] <= 903 for name in names if name["rank"] > 3)
    # names of less importance change nothing for those of more
    assert crowd["same"]
    # what has to be read stands, room or not
    assert crowd["forced"] == count


def test_names_keep_still_while_marks_tremble(home: str, page: Page) -> None:
    page.goto(f"{home}/login")
    crowd = page.evaluate(CROWD, {"seed": 5, "count": 150, "width": 900, "frames": 40, "step": 1.0})
    sides = [{name["key"]: name["side"] for name in frame} for frame in crowd["told"]]
    for before, after in pairwise(sides[5:]):
        gone = before.keys() - after.keys()
        moved = [key for key in before.keys() & after.keys() if before[key] != after[key]]
        assert len(gone) + len(moved) <= 0.03 * len(before)
    # over all frames hardly any comes and goes twice
    flicker = sum(
        sum(a != b for a, b in pairwise(seen)) > 2
        for seen in ([key in frame for frame in sides] for key in set().union(*sides))
    )
    assert flicker <= 0.05 * len(sides[0])


def test_far_out_the_plan_leaves_out_names_and_tells_them_when_pointed_at(home: str, page: Page) -> None:
    page.goto(home)
    expect(page.locator("#plan .mark.note")).to_have_count(30, timeout=SOON_MS)
    unnamed = page.locator("#plan .mark.note.unnamed")
    expect(unnamed.first).to_be_attached(timeout=SOON_MS)
    assert 0 < unnamed.count() < 30
    # a hazard's name has its place in the midst of them
    expect(page.locator("#plan .mark[data-kind='hazard'] .name")).to_be_visible()
    # a mark without a name tells it to who points at it, by keyboard too, and keeps it once it is selected
    words = (unnamed.first.get_attribute("aria-label") or "").removeprefix("note: ")
    mark = page.get_by_role("button", name=words)
    expect(mark.locator(".name")).to_be_hidden()
    mark.focus()
    expect(mark.locator(".name")).to_be_visible()
    page.keyboard.press("Enter")
    expect(mark).to_have_class("mark note selected")
