"""The tools of the plan in a real browser: finding, measuring, coordinates, keys."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from robots.tags.short_id import short_id
from server.app import create_app
from server.settings import Settings
from tests.web.driven import drive

pytestmark = pytest.mark.browser
SOON_MS = 60_000


HEARD = """
window.tones = [];
const start = OscillatorNode.prototype.start;
OscillatorNode.prototype.start = function (at) {
  window.tones.push(this.frequency.value);
  start.call(this, at);
};
"""


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_context(viewport={"width": 1366, "height": 768}, color_scheme="light").new_page()
    page.add_init_script(HEARD)
    yield page
    page.context.close()


@pytest.fixture
def home(serve: Any, tmp_path: Path) -> str:
    return f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off', reply_s=60.0)))}"


def test_the_plan_is_searched_measured_and_told_of(home: str, page: Page, robot_log: Any) -> None:
    seen = drive(page.request, home, robot_log)
    page.goto(home)
    expect(page.locator(".robot-card")).to_be_visible(timeout=SOON_MS)

    # the theme follows the device until one is chosen, and then stays
    root = page.locator("html")
    expect(root).to_have_attribute("data-theme", "daylight")
    page.get_by_label("Look of this page").click()
    page.get_by_label("Dark").check()
    expect(root).to_have_attribute("data-theme", "dark")
    page.reload()
    expect(root).to_have_attribute("data-theme", "dark")
    expect(page.locator(".robot-card")).to_be_visible(timeout=SOON_MS)

    # sounds are off until somebody turns them on; an alert that is new makes one, MAYDAY another
    assert page.evaluate("window.tones") == []
    page.get_by_label("Look of this page").click()
    page.get_by_label("For alerts, MAYDAY, EVACUATE").check()
    assert page.evaluate("window.tones") == [440]
    page.keyboard.press("Escape")
    alerts = f"{home}/api/v1/missions/drill/alerts"
    words = {"data": {"text": "hurt", "tag_id": seen["tag"]}, "headers": {"Origin": home}}
    assert page.request.post(f"{alerts}/mayday", **words).ok
    page.wait_for_function("() => window.tones.includes(1240)", timeout=SOON_MS)

    # a tag is found as its label has it, or by a part of its name; selected and brought into view
    page.get_by_role("searchbox").fill((short_id(seen["tag"]) or "").lower().replace("-", " "))
    expect(page.locator(".found button").first).to_contain_text(seen["tag"])
    page.keyboard.press("Escape")
    page.keyboard.press("/")
    page.keyboard.type(seen["tag"].lower())
    expect(page.locator(".found button").first).to_contain_text(seen["tag"])
    page.keyboard.press("ArrowDown")
    expect(page.locator(".found button").first).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator(f".tag-card[data-tag={seen['tag']}]")).to_be_visible()
    expect(page.locator("#plan")).to_be_focused()  # keys are short cuts again
    page.get_by_label("Find a robot").fill(seen["victim"])
    page.keyboard.press("Enter")
    expect(page.locator(".victim-card")).to_have_class(re.compile("selected"))
    page.get_by_label("Find a robot").fill("nothing is called so")
    expect(page.get_by_text("Nothing here is called that.")).to_be_visible()
    page.keyboard.press("Escape")

    # distances and areas: what is drawn is what the map's scale says, and Escape ends it
    page.keyboard.press("f")
    page.keyboard.press("m")
    for x, y in ((350, 180), (410, 180), (410, 240)):
        page.locator("#plan").click(position={"x": x, "y": y})
    told = page.locator(".measured p")
    expect(told).to_contain_text("inside")
    length_m, area_m2 = (float(words) for words in re.findall(r"[\d.]+", told.inner_text())[:2])
    side_m = length_m / 2.0
    assert abs(area_m2 - side_m**2 / 2.0) < 0.05 * area_m2 + 0.1
    page.get_by_role("button", name="Take back a corner").click()
    expect(told).not_to_contain_text("inside")
    page.locator("#plan").focus()
    page.keyboard.press("Enter")  # by the keyboard, in the middle of the plan
    expect(told).to_contain_text("inside")
    page.keyboard.press("Escape")
    expect(told).to_have_count(0)

    # layers of the ground: asked for when wanted, told what their colours mean, remembered
    page.get_by_role("button", name="Layers").click()
    for layer in ("Coverage", "Radio", "Ground as tags", "Selected robot's own map"):
        page.get_by_label(layer).check()
    key = page.get_by_label("What the colours of the ground mean")
    expect(key).to_contain_text(re.compile(r"cleared of victims, [1-9]\d* m²"), timeout=SOON_MS)
    expect(page.locator(".leaflet-layers-pane canvas.building")).to_be_attached(timeout=SOON_MS)
    page.keyboard.press("Escape")
    page.locator(".robot-card .card-body").click()
    expect(key).to_contain_text("as r1 alone has it", timeout=SOON_MS)
    expect(page.locator(".leaflet-layers-pane canvas.building")).to_have_count(2, timeout=SOON_MS)
    page.locator(".robot-card .card-body").click()

    # keys: a sheet tells them, numbers select robots, a letter orders the selected one
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_contain_text("The selected robot: return")
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.keyboard.press("1")
    expect(page.locator(".robot-card")).to_have_class(re.compile("selected"))
    page.keyboard.press("h")
    expect(page.locator(".robot-orders")).to_contain_text("Hold: waiting to be heard", timeout=SOON_MS)
    page.reload()  # an order that waits is not forgotten, nor are layers
    expect(key).to_contain_text("cleared of victims", timeout=SOON_MS)
    expect(page.locator(".robot-card .pending")).to_contain_text("Hold", timeout=SOON_MS)


MEASURED = """async () => {
  const { areaOf, lengthOf } = await import("/static/console/measure.js");
  const { gridReference } = await import("/static/console/grid_reference.js");
  const square = [[1, 1], [4, 1], [4, 5], [1, 5]];
  return {
    area: areaOf(square), turned: areaOf(square.toReversed()), length: lengthOf(square),
    names: [[0, 0], [9.99, 9.99], [10, 0], [-0.01, -0.01], [259, 999], [260, 1000]]
      .map(([x_m, y_m]) => gridReference(x_m, y_m)),
  };
}"""


def test_measures_and_names_of_squares_are_exact(home: str, page: Page) -> None:
    page.goto(f"{home}/login")
    assert page.evaluate(MEASURED) == {
        "area": 12,
        "turned": 12,
        "length": 10,
        "names": ["A00", "A00", "B00", "Z99", "Z99", "A00"],
    }


WINDOW_DRAWN = """async () => {
  const { drawMemories } = await import("/static/console/ground.js");
  const ctx = Object.assign(document.createElement("canvas"), { width: 100, height: 100 }).getContext("2d");
  const view = { scale: 10, toX: (x_m) => 50 + 10 * x_m, toY: (y_m) => 50 - 10 * y_m };
  drawMemories(ctx, view, { tags: [{ x_m: 1, y_m: 0, cell_m: 1, window: [".#.", "...", "o.."] }] });
  return [[70, 50], [60, 40], [50, 40], [50, 60]].map(([x, y]) => ctx.getImageData(x, y, 1, 1).data[3] > 0);
}"""


def test_what_tags_tell_lies_where_it_is(home: str, page: Page) -> None:
    """Of a window the first row is north, along x, and the first column west, along y."""
    page.goto(f"{home}/login")
    assert page.evaluate(WINDOW_DRAWN) == [True, False, True, False]


def test_without_webgl_and_without_scripts_the_page_says_so(home: str, page: Page) -> None:
    made = {"data": {"name": "Drill", "mission_id": "drill"}, "headers": {"Origin": home}}
    assert page.request.post(f"{home}/api/v1/missions", **made).ok
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(home)
    page.get_by_role("button", name="3D", exact=True).click()
    expect(page.get_by_text("No 3D in this browser")).to_be_visible(timeout=SOON_MS)
    page.route("**/vendor/leaflet/leaflet.js", lambda route: route.abort())
    page.reload()
    expect(page.get_by_text("Loading the console")).to_be_visible()
