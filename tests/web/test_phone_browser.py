"""The responder's phone in a real browser: at a tag that a robot left, led to the victim that it found."""

from __future__ import annotations

import io
import json
import re
import time
from collections.abc import Iterator
from math import atan2, degrees, hypot, log10, radians
from typing import Any

import httpx
import pytest
from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Page, expect

from server.app import create_app
from server.settings import Settings
from tests.web.conftest import Serve
from tests.web.field import Field, drive

SOON_MS = 15_000
PHONE = {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def field(tmp_path_factory: pytest.TempPathFactory, robot_log: Any) -> Iterator[Field]:
    serve = Serve()
    settings = Settings(data_dir=tmp_path_factory.mktemp("field"), login="off", reply_s=60.0)
    yield drive(serve(create_app(settings)), robot_log)
    serve.close()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport=PHONE, has_touch=True, locale="en-GB")
    yield context
    context.close()


@pytest.fixture
def page(context: BrowserContext) -> Page:
    return context.new_page()


def annotations(field: Field) -> list[dict[str, Any]]:
    with field.api as api:
        found: list[dict[str, Any]] = api.get("/annotations").json()["annotations"]
        return found


def wait_for_annotation(field: Field, text: str) -> dict[str, Any]:
    deadline = time.monotonic() + 20.0
    while True:
        found = [note for note in annotations(field) if note["text"] == text]
        if found:
            assert len(found) == 1
            return found[0]
        assert time.monotonic() < deadline, text
        time.sleep(0.1)


def keep(page: Page) -> None:
    """Wait until the page and a mission are on the phone."""
    page.evaluate("() => navigator.serviceWorker.ready")
    page.wait_for_function("async () => (await caches.keys()).length === 2")
    kept = "import('/static/phone/kept.js').then(({ all }) => all('pockets')).then((all) => all.length > 0)"
    page.wait_for_function(f"() => {kept}")


def test_a_responder_is_led_from_a_tag_to_the_victim_and_leaves_word(field: Field, page: Page) -> None:
    tag = field.links[0][0]
    page.goto(f"{field.home}/t")
    page.get_by_label("The number on the tag").fill(f" {tag[:1]} {tag[1:]} ")
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name=f"Tag {tag}")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_text(f"You are at tag {tag}.")).to_be_visible()

    page.get_by_role("button", name=f"Victim {field.victim}").click()
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
    note = wait_for_annotation(field, "stairs <b>broken</b>")
    assert (note["kind"], note["tag_id"], note["by"]) == ("hazard", tag, "operator")

    page.get_by_role("button", name="MAYDAY").click(delay=900)
    expect(page.get_by_text("MAYDAY was called")).to_be_visible(timeout=SOON_MS)
    with field.api as api:
        (alert,) = [a for a in api.get("/alerts").json()["alerts"] if a["kind"] == "mayday"]
        assert alert["tag_id"] == tag
        api.post("/evacuation").raise_for_status()
        page.get_by_role("button", name="I have heard it").click(timeout=SOON_MS)
        expect(page.locator("#alarm").get_by_role("button")).to_have_count(0)
        expect(page.get_by_text("goes out as soon as there is signal")).to_have_count(0, timeout=SOON_MS)
        assert [h["name"] for h in api.get("/evacuation").json()["acknowledged"]] == ["operator"]
        api.delete("/evacuation")
        api.delete("/alerts/mayday/operator")
        for note in annotations(field):
            api.delete(f"/annotations/{note['annotation_id']}")


def test_a_tag_that_nobody_knows_is_named(field: Field, page: Page) -> None:
    page.goto(f"{field.home}/t/nowhere")
    expect(page.get_by_role("alert")).to_contain_text("No mission here knows a tag nowhere.", timeout=SOON_MS)
    expect(page.get_by_label("The number on the tag")).to_be_visible()


def test_the_page_brings_the_answer_with_it(field: Field, context: BrowserContext) -> None:
    tag = field.links[0][0]
    context.route("**/api/**", lambda route: route.abort())
    context.route("**/app/**", lambda route: route.abort())
    page = context.new_page()
    response = page.goto(f"{field.home}/t/{tag}?mission=drill")
    expect(page.get_by_text(f"You are at tag {tag}.")).to_be_visible(timeout=SOON_MS)
    assert response is not None
    assert response.headers["cache-control"] == "private, no-store"
    with httpx.Client(base_url=field.home, headers={"Accept-Language": "fr, de;q=0.8, en"}) as client:
        (told,) = re.findall(r'id="told">(.*?)</script>', client.get(f"/t/{tag}").text)
        assert json.loads(told)["language"] == "de"
        where = client.get(f"/api/v1/where/{tag}", params={"language": "de"}).json()
        assert json.loads(told)["where"] == where
        for unknown in ("/t/nowhere", f"/t/{tag}?mission=other", "/phone"):
            assert 'id="told"></script>' in client.get(unknown).text, unknown


def test_a_phone_without_signal_opens_cold_answers_leads_and_keeps_reports(
    field: Field, context: BrowserContext
) -> None:
    page = context.new_page()
    page.goto(f"{field.home}/phone")
    keep(page)
    page.close()
    context.set_offline(True)
    cold = context.new_page()
    problems: list[str] = []
    cold.on("pageerror", lambda error: problems.append(str(error)))
    tag = field.links[0][0]
    cold.goto(f"{field.home}/t/{tag}")
    expect(cold.get_by_text(f"You are at tag {tag}.")).to_be_visible(timeout=SOON_MS)
    expect(cold.get_by_text(re.compile(r"Data of \d\d:\d\d, \d+ s old"))).to_be_visible()
    expect(cold.get_by_text("No signal.")).to_be_visible(timeout=SOON_MS)
    cold.get_by_role("button", name=f"Victim {field.victim}").click()
    expect(cold.locator(".go .number")).to_have_text(re.compile(r"\d+ m"))
    before = cold.locator(".go .text").first.inner_text()
    cold.get_by_role("button", name="Leave word here").click()
    cold.get_by_label("What is here").fill("floor gone")
    cold.get_by_role("button", name="Hazard").click()
    expect(cold.get_by_role("button", name="One report waits to be sent")).to_be_visible()
    cold.reload()
    expect(cold.get_by_role("button", name="One report waits to be sent")).to_be_visible(timeout=SOON_MS)
    expect(cold.locator(".go")).to_contain_text("Take care: floor gone.")  # it has not left the phone yet
    assert before in cold.locator(".go").inner_text()
    cold.goto(f"{field.home}/t/T-elsewhere")
    expect(cold.get_by_role("alert")).to_contain_text(
        "This phone does not know tag T-elsewhere", timeout=SOON_MS
    )
    assert annotations(field) == []
    context.set_offline(False)
    note = wait_for_annotation(field, "floor gone")
    assert (note["kind"], note["tag_id"]) == ("hazard", tag)
    expect(cold.get_by_role("button", name="waits to be sent")).to_have_count(0, timeout=SOON_MS)
    assert problems == []
    with field.api as api:
        api.delete(f"/annotations/{note['annotation_id']}")


def test_a_victim_is_counted_and_asked_about_step_by_step(field: Field, page: Page) -> None:
    tag = field.links[0][0]
    page.goto(f"{field.home}/t/{tag}")
    page.get_by_role("button", name="Leave word here").click(timeout=SOON_MS)
    page.get_by_role("button", name="Victim", exact=False).last.click()
    page.get_by_label("Live: one more").click()
    page.get_by_label("Dead: one more").click()
    page.get_by_role("button", name="No", exact=True).click()
    page.get_by_role("button", name="Up to 30").click()
    page.get_by_role("button", name="Yes", exact=True).click()
    page.get_by_role("button", name="Yes", exact=True).click()
    expect(page.get_by_text("START: delayed, yellow.")).to_be_visible()
    page.get_by_role("button", name="Leave this").click()
    expect(page.get_by_text(f"Victim left at tag {tag}.")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_role("button", name="waits to be sent")).to_have_count(0, timeout=SOON_MS)
    with field.api as api:
        found = [v for v in api.get("/victims").json()["victims"] if v["victim_id"].startswith("p-")]
        (victim,) = found
        assert (victim["live"], victim["dead"], victim["triage"]) == (2, 1, "delayed")
        assert victim["start"]["breaths_per_min"] == 20
        api.patch(f"/victims/{victim['victim_id']}", json={"status": "dismissed"})


def test_a_photo_waits_for_signal_like_any_report(field: Field, context: BrowserContext, page: Page) -> None:
    tag = field.links[0][0]
    picture = io.BytesIO()
    Image.new("RGB", (2400, 1200), (200, 30, 30)).save(picture, "PNG")
    page.goto(f"{field.home}/t/{tag}")
    page.get_by_role("button", name="Leave word here").click(timeout=SOON_MS)
    context.set_offline(True)
    page.get_by_label("What is here").fill("north wall")
    file = {"name": "wall.png", "mimeType": "image/png", "buffer": picture.getvalue()}
    page.get_by_label("Photo").set_input_files([file])
    expect(page.get_by_text(f"Photo left at tag {tag}.")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_role("button", name="One report waits to be sent")).to_be_visible()
    context.set_offline(False)
    expect(page.get_by_role("button", name="waits to be sent")).to_have_count(0, timeout=SOON_MS)
    with field.api as api:
        (photo,) = api.get("/photos").json()["photos"]
        assert (photo["tag_id"], photo["text"], photo["width"]) == (tag, "north wall", 1600)
        assert abs(photo["taken_unix_s"] - time.time()) < 120.0


SMALL = """() => {
  const all = [...document.querySelectorAll("body *")];
  const shown = all.filter((e) => e.checkVisibility() && !e.closest(".unseen"));
  const named = (found) => found.map((e) => e.outerHTML.slice(0, 80));
  const low = shown.filter((e) => e.matches("button, .button, input:not(.unseen), select"));
  const text = shown.filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()));
  return {
    low: named(low.filter((e) => e.getBoundingClientRect().height < 64)),
    small: named(text.filter((e) => parseFloat(getComputedStyle(e).fontSize) < 20)),
    wide: document.documentElement.scrollWidth - innerWidth,
  };
}"""
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
    expect(page.get_by_text(f"You are at tag {a}.")).to_be_visible(timeout=SOON_MS)
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
