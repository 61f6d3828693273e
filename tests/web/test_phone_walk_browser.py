"""A person with the phone walks: steps on the plan, the way spoken, a tag of another mission, who sees it."""

from __future__ import annotations

import re
import time
from typing import Any
from uuid import uuid4

import httpx
from playwright.sync_api import BrowserContext, Page, expect

from tests.web.field import START, Field

SOON_MS = 60_000
# A phone in a hand: a second of rest, then so many steps, each a push and a rest.
WALK = """async (steps) => {
  const feel = (g) => {
    const felt = { x: 0, y: 0.6 * g, z: 0.8 * g };
    dispatchEvent(Object.assign(new Event("devicemotion"), { accelerationIncludingGravity: felt }));
  };
  for (let k = 0; k < 12 * steps; k += 1) {
    feel(k % 12 < 6 ? 9.81 : 14);
    if (k % 12 === 5) await new Promise((done) => setTimeout(done, 320));
  }
}"""
PICTURE = "document.querySelector('canvas.plan').toDataURL()"
SPOKEN = """
  globalThis.spoken = [];
  SpeechSynthesis.prototype.speak = ({ text, lang }) => { globalThis.spoken.push([text, lang]); };
"""
WRITTEN = """
  globalThis.written = [];
  const fillText = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...where) {
    globalThis.written.push(text);
    return fillText.call(this, text, ...where);
  };
"""


def test_steps_are_told_and_drawn_with_an_error_that_grows(field: Field, page: Page) -> None:
    tag = field.links[0][0]
    page.goto(f"{field.home}/t/{tag}")
    expect(page.locator("canvas.plan")).to_be_visible(timeout=SOON_MS)
    counted = page.get_by_text("by this phone's own count")
    expect(counted).to_have_count(0)
    doubts = []
    for steps, of in ((2, "2 steps"), (4, "6 steps")):
        before = page.evaluate(PICTURE)
        page.evaluate(WALK, steps)
        expect(counted).to_have_text(re.compile(rf"^{of} from tag {tag} .*right to (\d+) m\.$"))
        doubts.append(int(re.findall(r"(\d+) m\.$", counted.inner_text())[0]))
        page.wait_for_function(f"(before) => {PICTURE} !== before", arg=before)
    assert doubts[0] < doubts[1]  # no compass: nobody knows which way
    page.get_by_label("The number on the tag").fill(field.links[0][1])
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", level=1)).to_have_text(f"Tag {field.links[0][1]}")
    expect(counted).to_have_count(0)  # a tag ends all doubt


def test_the_way_is_spoken_in_the_words_and_language_of_the_page(
    field: Field, context: BrowserContext
) -> None:
    context.add_init_script(SPOKEN)
    page = context.new_page()
    page.goto(f"{field.home}/t/{field.links[0][0]}")
    page.get_by_role("button", name=f"Victim {field.victim}").click(timeout=SOON_MS)
    page.get_by_role("button", name="Say it").click(timeout=SOON_MS)
    page.get_by_role("button", name="Deutsch").click(timeout=SOON_MS)
    german = page.locator(".go .text").last.inner_text()
    page.get_by_role("button", name="Vorlesen").click()
    (english, lang), (said, sprache) = page.evaluate("spoken")
    assert (lang, sprache) == ("en", "de")
    assert re.search(r"\d+ m", english)
    assert said.strip().endswith(german)
    assert english != said


def test_a_tag_of_another_mission_leads_into_that_mission(field: Field, page: Page) -> None:
    with httpx.Client(base_url=f"{field.home}/api/v1", timeout=90) as api:
        _another_mission(api)
        page.goto(f"{field.home}/t/{field.links[0][0]}")
        page.get_by_role("button", name=f"Victim {field.victim}").click(timeout=SOON_MS)
        expect(page.locator(".go")).to_be_visible(timeout=SOON_MS)
        page.get_by_label("The number on the tag").fill("B0")
        page.get_by_role("button", name="Where am I?").click()
        expect(page.get_by_text("You are at tag B0")).to_be_visible(timeout=SOON_MS)
        expect(page.get_by_text("Other mission", exact=True)).to_be_visible(timeout=SOON_MS)
        expect(page.locator(".go")).to_have_count(0)  # the goal is of the first
        expect(page.get_by_role("button", name=f"Victim {field.victim}")).to_have_count(0)
        page.get_by_role("button", name="Leave word here").click()
        page.get_by_label("What is here").fill("wet")
        page.get_by_role("button", name="Hazard").click()
        deadline = time.monotonic() + 60.0
        while not (notes := api.get("/missions/other/annotations").json()["annotations"]):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        assert [(note["text"], note["tag_id"]) for note in notes] == [("wet", "B0")]
        assert api.get("/missions/drill/annotations").json()["annotations"] == []
        page.go_back()  # and back in the first, it leads on
        expect(page.locator(".go")).to_be_visible(timeout=SOON_MS)


def _another_mission(api: httpx.Client) -> None:
    words: dict[str, Any] = {"name": "Other mission", "mission_id": "other", "tag_key": ""}
    api.post("/missions", json=words).raise_for_status()
    api.post("/missions/other/robots", json={"robot_id": "r1", "start_pose": START}).raise_for_status()
    still = {"kind": "displacement", "dx_m": 0.0, "dy_m": 0.0, "dtheta_rad": 0.0}
    seen = {"seq": 0, "stamp_s": 0.0, "odometry": still, "tag_sightings": [{"tag_id": "B0"}]}
    body = {"observations": [seen]}
    api.post("/missions/other/robots/r1/observations", json=body).raise_for_status()
    deadline = time.monotonic() + 60.0
    while not api.get("/missions/other/tags").json()["tags"]:
        assert time.monotonic() < deadline
        time.sleep(0.1)


def test_a_commander_sees_who_is_at_which_tag_and_since_when(field: Field, context: BrowserContext) -> None:
    tag = field.links[0][0]
    now = time.time()
    with field.api as api:
        for who, ago_s in (("ann", 300.0), ("ann", 4000.0), ("ben", 62.0)):  # what is older is no news
            clocks = {"phone_unix_s": now - ago_s, "offset_s": None, "sent_phone_unix_s": now}
            body = {"kind": "at", "tag_id": tag, "made_by": who, **clocks}
            api.put(f"/reports/{uuid4()}", json=body).raise_for_status()
    context.add_init_script(WRITTEN)
    page = context.new_page()
    page.set_viewport_size({"width": 1366, "height": 768})
    page.goto(f"{field.home}/console?mission=drill")
    people = "/(^|; )ben, [1-4] min ago; ann, [5-9] min ago$/"
    page.wait_for_function(f"() => written.some((text) => {people}.test(text))", timeout=SOON_MS)
