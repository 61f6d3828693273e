"""Saying which tag one is at: by the camera on a printed label, or by its number as people type it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Page, expect

from robots.tags.short_id import short_id
from server.labels import Sheet, sheets
from tests.web.camera_film import write_film
from tests.web.conftest import CHROMIUM

SOON_MS = 60_000
PHONE = {"width": 390, "height": 844}
JSQR = Path(__file__).parents[2] / "web/node_modules/jsqr/dist/jsQR.js"
# The interface of https://wicg.github.io/shape-detection-api/ where the system has a reader. Linux has none:
# one that the page does not know of stands in for it.
DETECTOR = """
  const read = ((module, exports) => { SOURCE; return module.exports; })({ exports: {} }, {});
  globalThis.BarcodeDetector = class {
    static getSupportedFormats = async () => FORMATS;
    constructor({ formats }) {
      if (!formats.length || formats.some((each) => !FORMATS.includes(each))) throw new TypeError("formats");
    }
    async detect(image) {
      const { width, height } = image;
      const found = read(image.getContext("2d").getImageData(0, 0, width, height).data, width, height);
      globalThis.detected = (globalThis.detected ?? 0) + 1;
      if (globalThis.detected === 1) throw new DOMException("not yet", "InvalidStateError");
      if (!found) return [];
      const { topLeftCorner: a, topRightCorner: b, bottomRightCorner: c } = found.location;
      const cornerPoints = [a, b, c, found.location.bottomLeftCorner];
      return [{ rawValue: found.data, format: "qr_code", cornerPoints,
        boundingBox: DOMRectReadOnly.fromRect({ x: a.x, y: a.y, width: c.x - a.x, height: c.y - a.y }) }];
    }
  };
"""


def label(tag_id: str, site: str) -> Image.Image:
    """A label as it is printed."""
    figure = next(sheets([tag_id], site, Sheet()))
    figure.set_dpi(150)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    sheet = Image.fromarray(np.asarray(canvas.buffer_rgba()))
    return sheet.crop((0, 0, sheet.width // 2, sheet.height // 4))


@pytest.fixture
def before_camera(browser: Browser) -> Iterator[Any]:
    """Return a function that opens a browser whose camera looks at a picture."""
    opened = []

    def open_before(path: Path, picture: Image.Image) -> Browser:
        write_film(path, [picture])
        flags = [
            "--no-sandbox",
            "--use-fake-device-for-media-stream",
            f"--use-file-for-fake-video-capture={path}",
        ]
        opened.append(browser.browser_type.launch(executable_path=CHROMIUM, args=flags))
        return opened[-1]

    yield open_before
    for each in opened:
        each.close()


def at_the_door(context: BrowserContext, host: str) -> Page:
    page = context.new_page()
    page.goto(f"http://{host}/t")
    page.get_by_role("button", name="Scan a label").click()
    return page


def test_the_camera_on_a_printed_label_opens_its_tag(drill: Any, before_camera: Any, tmp_path: Path) -> None:
    tag_id = drill["tags"][0]
    camera = before_camera(tmp_path / "film.y4m", label(tag_id, f"http://{drill['host']}"))
    page = at_the_door(camera.new_context(viewport=PHONE, permissions=["camera"]), drill["host"])
    expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
    assert page.url.endswith(f"/t/{tag_id}")

    refused = at_the_door(camera.new_context(viewport=PHONE), drill["host"])
    expect(refused.get_by_role("alert")).to_contain_text("The camera may not be used here.", timeout=SOON_MS)
    expect(refused.get_by_label("The number on the tag")).to_be_visible()


@pytest.mark.parametrize("formats", [["aztec", "qr_code"], ["aztec"]])
def test_a_browser_that_reads_codes_itself_loads_no_reader(
    drill: Any, before_camera: Any, tmp_path: Path, formats: list[str]
) -> None:
    tag_id, host = drill["tags"][0], drill["host"]
    camera = before_camera(tmp_path / "film.y4m", label(tag_id, f"http://{host}"))
    context = camera.new_context(viewport=PHONE, permissions=["camera"], service_workers="block")
    detector = DETECTOR.replace("FORMATS", json.dumps(formats)).replace("SOURCE", JSQR.read_text())
    context.add_init_script(f"(() => {{ {detector} }})()")
    loaded: list[str] = []
    context.on("request", lambda request: loaded.append(request.url))
    page = at_the_door(context, host)
    expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
    does_itself = "qr_code" in formats
    assert (f"http://{host}/vendor/jsqr/jsQR.js" in loaded) != does_itself
    assert page.evaluate("() => [typeof jsQR, globalThis.detected > 1]") == (
        ["undefined", True] if does_itself else ["function", False]
    )


def test_a_label_of_another_server_is_asked_about(drill: Any, before_camera: Any, tmp_path: Path) -> None:
    tag_id = drill["tags"][0]
    camera = before_camera(tmp_path / "film.y4m", label(tag_id, "https://usar.example"))
    page = at_the_door(camera.new_context(viewport=PHONE, permissions=["camera"]), drill["host"])
    expect(page.get_by_role("alert")).to_contain_text("for another server, usar.example", timeout=SOON_MS)
    page.get_by_role("button", name=f"Open our {tag_id}").click()
    expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)


def test_numbers_are_understood_as_people_type_them(drill: Any, browser: Browser) -> None:
    tag_id = drill["tags"][0]
    context = browser.new_context(viewport=PHONE)
    context.add_init_script("Object.defineProperty(navigator, 'mediaDevices', { value: undefined })")
    page = at_the_door(context, drill["host"])  # as on a page without https
    expect(page.get_by_role("alert")).to_contain_text(
        "keeps the camera for pages with https", timeout=SOON_MS
    )
    number = page.get_by_label("The number on the tag")
    written = short_id(tag_id)
    assert written is not None
    wrong = written[:-1] + ("0" if written[-1] != "0" else "2")
    number.fill(wrong)
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("alert")).to_contain_text(re.compile(f"No tag here has the number {wrong}"))
    page.route("**/api/v1/where?*", lambda route: route.fulfill(status=401, json={}))
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("alert")).to_contain_text("Log in: the server may know it.")
    page.unroute("**/api/v1/where?*")
    page.route("**/api/v1/where?*", lambda route: route.abort())
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("alert")).to_contain_text("and the server cannot be reached.")
    page.unroute("**/api/v1/where?*")
    number.fill(written.lower().replace("-", " "))
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
    context.close()


def test_a_damaged_link_opens_a_page_that_helps_on(drill: Any, page: Page) -> None:
    page.goto(f"http://{drill['host']}/t/A%zz")
    expect(page.get_by_role("alert")).to_contain_text(
        "That link is damaged: A%zz is no tag.", timeout=SOON_MS
    )
    expect(page.get_by_label("The number on the tag")).to_be_visible()
    expect(page.get_by_role("button", name="MAYDAY")).to_be_visible()
