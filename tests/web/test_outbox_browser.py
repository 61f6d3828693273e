"""Reports over a link that fails in every way: none lost, none doubled, the most important first."""

from __future__ import annotations

import random
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from server.app import create_app
from server.benchmarks import outbox
from server.benchmarks.browser import OWN_MODULE
from server.benchmarks.outbox_field import PEOPLE, FieldOfTags, links
from server.settings import Settings

SEQUENCES = 8
SOON_MS = 60_000
DAYS_MS = 5 * 86_400_000
ADD = """async (all) => {
  const { add } = await OWN("/static/phone/outbox.js");
  for (const [kind, body] of all) await add(kind, "field", body);
}""".replace("OWN", OWN_MODULE)
PHOTO = """async () => {
  const { add } = await OWN("/static/phone/outbox.js");
  add("photo", "field", { tag_id: "T0", text: "", picture: new Blob(["x"], { type: "image/jpeg" }) });
}""".replace("OWN", OWN_MODULE)
SESSION = """([method, words]) => fetch("/api/v1/session", {
  method, body: words && JSON.stringify(words), headers: words ? { "Content-Type": "application/json" } : {},
})"""
FULL = """
  const put = IDBObjectStore.prototype.put;
  IDBObjectStore.prototype.put = function (...given) {
    if (globalThis.isFull) throw new DOMException("no room", "QuotaExceededError");
    return put.apply(this, given);
  };
"""


@pytest.fixture
def home(serve: Any, tmp_path: Path) -> str:
    return f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off')))}"


@pytest.fixture
def client(home: str) -> Iterator[httpx.Client]:
    """A client of a server with an empty mission."""
    with httpx.Client(base_url=f"{home}/api/v1", timeout=90) as client:
        words = {"name": "Field", "mission_id": "field", "tag_key": ""}
        client.post("/missions", json=words).raise_for_status()
        yield client


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(service_workers="block", locale="en-GB")
    yield context
    context.close()


def opened(context: BrowserContext, home: str) -> Page:
    """The phone's page, with the mission on the phone."""
    page = context.new_page()
    page.goto(f"{home}/phone")
    expect(page.get_by_text("Data of")).to_be_visible(timeout=SOON_MS)
    return page


def note(text: str, kind: str = "note") -> list[Any]:
    return ["note", {"note": kind, "text": text, "tag_id": "T0"}]


def reports(client: httpx.Client, count: int) -> list[dict[str, Any]]:
    deadline = time.monotonic() + 60.0
    while True:
        found: list[dict[str, Any]] = client.get("/missions/field/reports").json()["reports"]
        if len(found) >= count or time.monotonic() > deadline:
            assert len(found) == count
            return found[::-1]
        time.sleep(0.1)


def test_no_report_is_lost_or_doubled(serve: Any, tmp_path: Path, browser: Browser) -> None:
    secrets = links(tmp_path)
    home = f"http://{serve(create_app(Settings(data_dir=tmp_path, login='on')))}"
    field = FieldOfTags(home, secrets, random.Random(2))
    phones = [browser.new_context(service_workers="block") for _ in PEOPLE]
    tally = outbox.run(phones, field, SEQUENCES, seed=1, page="/phone")
    for each in phones:
        each.close()
    field.close()
    assert {kind for kind, _ in tally.made.values()} >= {"note", "victim", "photo", "mayday"}
    assert tally.victims > 0
    met = "lost on the way there", "lost on the way back", "reload", "handed over", "written into a tag"
    assert min(tally.faults[name] for name in met) > 0
    assert tally.lost == []
    assert tally.doubled == []


def test_the_most_important_goes_first_and_the_server_refuses_in_words(
    home: str, client: httpx.Client, context: BrowserContext
) -> None:
    page = opened(context, home)
    context.set_offline(True)
    wrong = ["note", {"note": "note", "text": "odd tag", "tag_id": "T 0"}]
    mayday = ["mayday", {"text": "", "tag_id": None}]
    victim = ["victim", {"tag_id": "T0", "live": 1, "dead": 0}]
    page.evaluate(ADD, [note("a"), wrong, note("b", "hazard"), victim, mayday])
    expect(page.get_by_role("button", name="5 reports wait to be sent")).to_be_visible()
    expect(page.get_by_text(re.compile(r"MAYDAY of \d\d:\d\d is NOT sent yet"))).to_be_visible()
    context.set_offline(False)
    kinds = [report["body"].get("note") or report["kind"] for report in reports(client, 4)]
    assert sorted(kinds, key="mayday".__eq__)[:3] == ["victim", "hazard", "note"]  # MAYDAY goes by itself
    assert "mayday" in kinds
    expect(page.get_by_text("One report was refused by the server.")).to_be_visible(timeout=SOON_MS)
    page.get_by_role("button", name="One report waits").click()
    expect(page.get_by_text("The server cannot read it.")).to_contain_text("tag_id")
    page.get_by_role("button", name="Throw it away").click()
    expect(page.get_by_role("button", name="waits to be sent")).to_have_count(0)


def test_no_word_waits_for_a_photo_that_does_not_go_out(
    home: str, client: httpx.Client, context: BrowserContext
) -> None:
    page = opened(context, home)
    page.route("**/photos?*", lambda route: None)  # never answered
    with page.expect_request("**/photos?*"):
        page.evaluate(PHOTO)
    page.evaluate(ADD, [note("gas", "hazard")])
    assert [report["body"]["text"] for report in reports(client, 1)] == ["gas"]


def test_a_full_storage_is_said_and_nothing_is_lost_while_the_page_is_open(
    home: str, client: httpx.Client, context: BrowserContext
) -> None:
    context.add_init_script(FULL)
    page = opened(context, home)
    context.set_offline(True)
    page.evaluate("() => { globalThis.isFull = true; }")
    page.evaluate(ADD, [note("kept in memory")])
    expect(page.get_by_text("This phone's storage is full. Reports are kept only until")).to_be_visible()
    page.get_by_role("button", name="One report waits").click()
    expect(page.get_by_text(re.compile("Note @ T0 · kept in memory"))).to_be_visible()  # to be read out
    context.set_offline(False)
    assert [report["body"]["text"] for report in reports(client, 1)] == ["kept in memory"]
    expect(page.get_by_text("This phone's storage is full")).to_have_count(0, timeout=SOON_MS)


def test_a_clock_that_is_days_off_is_told_of_and_reports_have_the_right_time(
    home: str, client: httpx.Client, context: BrowserContext
) -> None:
    context.add_init_script(f"const now = Date.now; Date.now = () => now() - {DAYS_MS};")
    page = opened(context, home)
    expect(page.get_by_text("This phone's clock is wrong.")).to_be_visible(timeout=SOON_MS)
    context.set_offline(True)
    page.evaluate(ADD, [note("in time")])
    context.set_offline(False)
    (report,) = reports(client, 1)
    assert abs(report["made_unix_s"] - time.time()) < 60.0
    assert abs(report["phone_unix_s"] + DAYS_MS / 1000 - time.time()) < 60.0
    assert abs(report["offset_s"] - DAYS_MS / 1000) < 5.0


def test_logged_out_a_report_is_kept_and_signed_by_who_made_it(
    serve: Any, tmp_path: Path, context: BrowserContext, capsys: pytest.CaptureFixture[str]
) -> None:
    home = f"http://{serve(create_app(Settings(data_dir=tmp_path, login='on')))}"
    printed = ""
    while "/join#" not in printed:
        printed += capsys.readouterr().out
        time.sleep(0.05)
    with httpx.Client(base_url=f"{home}/api/v1", timeout=90) as client:
        _logged_out(home, client, printed, context)


def _logged_out(home: str, client: httpx.Client, printed: str, context: BrowserContext) -> None:
    ann, ben = ({"name": name, "password": f"{name}'s long password"} for name in ("ann", "ben"))
    client.post("/join", json={"secret": printed.split("/join#")[1].split()[0], **ann}).raise_for_status()
    link = client.post("/links", json={"role": "responder"}).json()["path"]
    httpx.post(f"{home}/api/v1/join", json={"secret": link.split("#")[1], **ben}).raise_for_status()
    client.post("/missions", json={"name": "Field", "mission_id": "field", "tag_key": ""}).raise_for_status()

    page = context.new_page()
    page.goto(f"{home}/phone")
    expect(page.get_by_text("You are logged out.")).to_be_visible(timeout=SOON_MS)
    page.evaluate(SESSION, ["POST", ann])
    page.reload()
    expect(page.get_by_text("Data of")).to_be_visible(timeout=SOON_MS)
    page.evaluate(SESSION, ["DELETE", None])
    page.evaluate(ADD, [note("by ann")])
    for _ in range(2):
        expect(page.get_by_text("You are logged out. One report is kept")).to_be_visible(timeout=SOON_MS)
        page.reload()
    page.evaluate(SESSION, ["POST", ben])
    page.reload()
    (report,) = reports(client, 1)
    assert (report["body"]["text"], report["by"]) == ("by ann", "ann (sent by ben)")
