"""Two phones without a server: one shows its reports as codes, the other reads them; each counts once."""

from __future__ import annotations

import io
import time
from pathlib import Path
from typing import Any

import httpx
from PIL import Image
from playwright.sync_api import Browser, Page, expect

from server.benchmarks.browser import OWN_MODULE
from tests.web.camera_film import write_film
from tests.web.conftest import CHROMIUM

SOON_MS = 60_000
PHONE = {"width": 390, "height": 844}


def leave(page: Page, words: list[str]) -> None:
    for text in words:
        page.get_by_role("button", name="Leave word here").click()
        page.get_by_label("What is here").fill(text)
        page.get_by_role("button", name="Hazard").click()
        expect(page.get_by_text("Hazard left at tag")).to_be_visible()


def codes(page: Page) -> list[Image.Image]:
    """Pictures of all codes that a phone shows, one after the other."""
    found: dict[str, Image.Image] = {}
    while True:
        code = page.locator(".handover .code")
        name = code.get_attribute("data-code") or ""
        count = int(name.split(":")[3])
        shown = Image.open(io.BytesIO(code.screenshot()))
        if code.get_attribute("data-code") == name:
            found[name] = shown
        if len(found) == count:
            return list(found.values())


def hazards(host: str) -> list[tuple[str, str]]:
    found = httpx.get(f"http://{host}/api/v1/missions/drill/annotations", timeout=30).json()["annotations"]
    return sorted((note["text"], note["tag_id"]) for note in found if note["kind"] == "hazard")


def test_reports_go_from_phone_to_phone_and_arrive_once(drill: Any, browser: Browser, tmp_path: Path) -> None:
    host, tag_id = drill["host"], drill["tags"][0]
    words = [f"hole {k}, take the left side <b>{'x' * 60 * k}</b>" for k in range(6)]
    first = browser.new_context(viewport=PHONE, locale="en-GB")
    page = first.new_page()
    page.goto(f"http://{host}/t/{tag_id}")
    expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
    expect(page.get_by_role("button", name="Leave word here")).to_be_visible(timeout=SOON_MS)
    first.set_offline(True)
    leave(page, words)
    page.get_by_role("button", name="6 reports wait to be sent").click()
    page.get_by_role("button", name="Hand them to another phone").click()
    write_film(tmp_path / "film.y4m", shown := codes(page))
    assert len(shown) > 1
    assert hazards(host) == []

    flags = ["--no-sandbox", "--use-fake-device-for-media-stream"]
    flags.append(f"--use-file-for-fake-video-capture={tmp_path / 'film.y4m'}")
    other = browser.browser_type.launch(executable_path=CHROMIUM, args=flags)
    try:
        second = other.new_context(viewport=PHONE, locale="en-GB", permissions=["camera"])
        reader = second.new_page()
        reader.goto(f"http://{host}/phone")
        reader.get_by_role("button", name="Scan a label").click()
        expect(reader.get_by_text("6 reports were taken over.")).to_be_visible(timeout=60_000)
        deadline = time.monotonic() + 60.0
        while len(hazards(host)) < 6:
            assert time.monotonic() < deadline, hazards(host)
            time.sleep(0.2)
    finally:
        other.close()
    first.set_offline(False)  # now their writer's phone sends them too
    expect(page.get_by_role("button", name="reports wait")).to_have_count(0, timeout=60_000)
    assert hazards(host) == sorted((text, tag_id) for text in words)
    first.close()


BREAK = """async () => {
  const { Collector, framesOf } = await import("/static/phone/handover.js");
  const report = (text) => ({
    id: crypto.randomUUID(), mission_id: "m", kind: "note", body: { note: "note", text }, made_by: "Kim",
    phone_unix_s: 5, offset_s: null,
  });
  const good = await framesOf(Array.from({ length: 40 }, () => report(crypto.randomUUID())));
  const collect = async (texts) => {
    const collector = new Collector();
    const taken = texts.map((text) => collector.take(text));
    if (!collector.isWhole) return [taken.some(Boolean), "not whole"];
    return collector.reports().then((reports) => [true, reports.length], () => [true, "refused"]);
  };
  const wrong = good[0].replace(/:[^:]*$/, good[1].slice(good[1].lastIndexOf(":")));
  return {
    shuffled: await collect([...good].reverse().concat(good)),
    missing: await collect(good.slice(1)),
    swapped: await collect([wrong, ...good.slice(1)]),
    bomb: await collect(await framesOf([report("0".repeat(5_000_000))])),
    other: await collect(["https://usar.example/t/A4", "WAYMARK1:zz:0:1:AAAA"]),
    rubbish: await collect(["WAYMARK1:0:0:1:AAAA"]),
    forged: await collect(await framesOf([
      { ...report("x"), body: { note: "note", text: "x", made_by: "Ann" } },
      { ...report("x"), body: { note: "note", text: "x", kind: "mayday" } },
      { ...report("x"), body: { note: "onceler", text: "x" } },
      { ...report("x"), body: { note: "note", text: {} } },
      { ...report("x"), made_by: "x".repeat(61) },
    ])),
    strange: await collect(await framesOf([{ ...report("x"), id: "../x" }, report("y")])),
  };
}"""


def test_codes_in_any_order_damaged_or_foreign(browser: Browser, drill: Any) -> None:
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"http://{drill['host']}/static/logo.svg")
    assert page.evaluate(BREAK) == {
        "shuffled": [True, 40],
        "missing": [True, "not whole"],
        "swapped": [True, "refused"],
        "bomb": [True, "refused"],
        "other": [False, "not whole"],
        "rubbish": [True, "refused"],
        "forged": [True, 0],
        "strange": [True, 1],
    }
    context.close()


OFFER = """async ([mission, tag]) => {
  const { framesOf } = await OWN("/static/phone/handover.js");
  const { takeCode } = await OWN("/static/phone/handover_view.js");
  const report = (kind, body) => ({
    id: crypto.randomUUID(), mission_id: mission, kind, body: { text: "", tag_id: tag, ...body },
    made_by: "operator", phone_unix_s: 5, offset_s: null,
  });
  const said = [report("mayday", {}), report("note", { note: "note" })];
  for (const frame of await framesOf(said)) takeCode(frame);
}""".replace("OWN", OWN_MODULE)


def test_a_poster_calls_no_mayday_in_the_name_of_who_scans_it(browser: Browser, drill: Any) -> None:
    """It bears the scanner's own name: what calls others is asked about, and all is signed as carried."""
    home, tag = f"http://{drill['host']}", drill["tags"][0]
    context = browser.new_context(viewport=PHONE, locale="en-GB")
    page = context.new_page()
    page.goto(f"{home}/t/{tag}")
    expect(page.get_by_role("button", name="MAYDAY")).to_be_visible(timeout=SOON_MS)
    page.evaluate(OFFER, ["drill", tag])
    offered = page.get_by_role("alert").filter(has_text="MAYDAY")
    expect(offered).to_contain_text(f"MAYDAY @ {tag} · operator")
    expect(page.get_by_text("One report was taken over.")).to_be_visible()
    offered.get_by_role("button", name="Leave it").click()
    expect(offered).to_have_count(0)
    page.evaluate(OFFER, ["drill", tag])
    offered.get_by_role("button", name="Take it").click()
    with httpx.Client(base_url=f"{home}/api/v1/missions/drill", timeout=60) as api:
        deadline = time.monotonic() + 60.0
        while not (alerts := [a for a in api.get("/alerts").json()["alerts"] if a["kind"] == "mayday"]):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        assert [alert["text"].split(",")[0] for alert in alerts] == [
            f"MAYDAY from operator (carried by operator) near tag {tag}"
        ]
        while not (kept := [n for n in api.get("/reports").json()["reports"] if n["kind"] == "mayday"]):
            assert time.monotonic() < deadline  # it is told before it is kept
            time.sleep(0.1)
        assert len(kept) == 1
    expect(page.get_by_role("button", name="MAYDAY: press and hold")).to_be_visible()  # it is not one's own
    context.close()
