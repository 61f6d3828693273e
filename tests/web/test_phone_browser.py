"""The responder's phone in a real browser: at a tag that a robot left, led to the victim that it found."""

from __future__ import annotations

import io
import json
import re
import time
from typing import Any

import httpx
from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Page, Response, expect

from server.benchmarks.browser import OWN_MODULE
from tests.web.field import Field, keep

SOON_MS = 60_000
SHOWN = f"""async () => {{
  const {{ roads }} = (await {OWN_MODULE}("/static/phone/state.js")).state;
  return roads && roads.notes.map(({{ annotation_id, kind }}) => [annotation_id, kind]);
}}"""


def annotations(field: Field) -> list[dict[str, Any]]:
    with field.api as api:
        found: list[dict[str, Any]] = api.get("/annotations").json()["annotations"]
        return found


def wait_for_annotation(field: Field, text: str) -> dict[str, Any]:
    deadline = time.monotonic() + 60.0
    while True:
        found = [note for note in annotations(field) if note["text"] == text]
        if found:
            assert len(found) == 1
            return found[0]
        assert time.monotonic() < deadline, text
        time.sleep(0.1)


def test_a_responder_is_led_from_a_tag_to_the_victim_and_leaves_word(field: Field, page: Page) -> None:
    tag = field.links[0][0]
    page.goto(f"{field.home}/t")
    page.get_by_label("The number on the tag").fill(f" {tag[:1]} {tag[1:]} ")
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name=f"Tag {tag}")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_text(f"You are at tag {tag}")).to_be_visible()

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


def test_the_way_out_leads_to_an_exit_and_a_number_to_its_tag(
    field: Field, context: BrowserContext, page: Page
) -> None:
    here = field.links[0][0]
    there = httpx.get(f"{field.home}/api/v1/where/{here}").json()["neighbours"][0]["tag_id"]
    page.goto(f"{field.home}/t/{there}")
    expect(page.get_by_text("No exit is marked yet.")).to_be_visible(timeout=SOON_MS)
    context.set_offline(True)  # whoever marks one has it at once
    page.get_by_role("button", name="Leave word here").click()
    page.get_by_role("button", name="Exit").click()
    expect(page.get_by_role("button", name="The way out here")).to_be_visible(timeout=SOON_MS)
    context.set_offline(False)
    exit_ = wait_for_annotation(field, "")
    assert (exit_["kind"], exit_["tag_id"]) == ("exit", there)
    with field.api as api:
        while not api.get("/pocket").json()["notes"]:  # it is packed once a second at most
            time.sleep(0.1)
    page.goto(f"{field.home}/t/{here}")
    page.get_by_role("button", name=re.compile(r"The way out \d+ m")).click(timeout=SOON_MS)
    guide = page.locator(".go")
    guide.get_by_role("link", name=f"I am at {there}").click(timeout=SOON_MS)
    expect(page.get_by_role("heading", level=1)).to_have_text(f"Tag {there}")
    guide.get_by_role("button", name="Done").click(timeout=SOON_MS)
    page.get_by_label("The number on the tag").fill(here)
    page.get_by_role("button", name="Lead me to this tag").click()
    expect(guide.get_by_role("link", name=f"I am at {here}")).to_be_visible(timeout=SOON_MS)
    with field.api as api:
        api.delete(f"/annotations/{exit_['annotation_id']}")


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
    expect(page.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_text("Loading.")).to_be_visible(timeout=SOON_MS)  # the rest does not come
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
    expect(cold.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)
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


def test_only_what_has_changed_is_fetched_again(field: Field, page: Page) -> None:
    tag = field.links[0][0]
    fetched: list[Response] = []
    page.on("response", lambda said: "/pocket" in said.url and said.ok and fetched.append(said))
    page.goto(f"{field.home}/t/{tag}")
    keep(page)
    first, *rest = [said.json() for said in fetched]
    assert {"tags", "ways", "map"} <= set(first)
    assert not any("tags" in told for told in rest)  # nor is the whole fetched twice
    fetched.clear()
    with field.api as api:
        whole = api.get("/pocket").json()
        note = {"kind": "hazard", "text": "gas", "tag_id": tag}
        api.put("/annotations/00000000-0000-4000-8000-00000000feed", json=note).raise_for_status()
        page.get_by_role("button", name=f"Victim {field.victim}").click(timeout=SOON_MS)
        expect(page.locator(".go")).to_contain_text("Take care: gas.", timeout=SOON_MS)  # by itself
        assert fetched
        for told in [said.json() for said in fetched]:
            assert not {"tags", "ways", "map"} & set(told)
            assert told["parts"] == whole["parts"]
        api.delete("/annotations/00000000-0000-4000-8000-00000000feed")
    page.reload()  # what is kept is whole
    expect(page.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)
    kept = page.evaluate("import('/static/phone/kept.js').then(({ all }) => all('pockets'))")
    assert {key: json.loads(kept[0]["text"])[key] for key in ("tags", "ways", "map")} == {
        key: whole[key] for key in ("tags", "ways", "map")
    }


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


def wait_for_notes(page: Page, ids: list[list[str]]) -> None:
    same = f"async (ids) => JSON.stringify(await ({SHOWN})()) === JSON.stringify(ids)"
    page.wait_for_function(same, arg=ids)


def test_what_was_sent_stays_until_the_mission_on_the_phone_has_it(field: Field, browser: Browser) -> None:
    context = browser.new_context(service_workers="block", locale="en-GB")
    page = context.new_page()
    page.goto(f"{field.home}/t/{field.links[0][0]}")
    expect(page.get_by_text("No exit is marked yet.")).to_be_visible(timeout=SOON_MS)
    wait_for_notes(page, [])
    context.route("**/pocket", lambda route: route.abort())
    page.get_by_role("button", name="Leave word here").click()
    page.get_by_role("button", name="Exit").click()
    exit_ = [[wait_for_annotation(field, "")["annotation_id"], "exit"]]
    expect(page.get_by_role("button", name="waits to be sent")).to_have_count(0, timeout=SOON_MS)
    assert page.evaluate(SHOWN) == exit_
    page.reload()
    expect(page.get_by_role("button", name="The way out here")).to_be_visible(timeout=SOON_MS)
    wait_for_notes(page, exit_)
    with field.api as api:
        while not api.get("/pocket").json()["notes"]:  # it is packed once a second at most
            time.sleep(0.1)
        context.unroute("**/pocket")
        page.reload()
        page.wait_for_function("() => localStorage.getItem('waymark.sent') === '[]'")
        wait_for_notes(page, exit_)
        api.delete(f"/annotations/{exit_[0][0]}").raise_for_status()
    wait_for_notes(page, [])
    context.close()
