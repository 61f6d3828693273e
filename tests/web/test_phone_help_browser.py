"""EVACUATE and MAYDAY are in view on every page of the phone, however far it was scrolled."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.web.field import Field, keep

SOON_MS = 60_000
FAR_DOWN = "scrollTo({ top: document.documentElement.scrollHeight, behavior: 'instant' })"


@pytest.mark.parametrize("at_tag", [False, True])
def test_evacuate_stays_in_view_and_is_heard_with_one_tap(field: Field, page: Page, at_tag: bool) -> None:
    page.set_viewport_size({"width": 390, "height": 500})
    page.goto(f"{field.home}/t/{field.links[0][0]}" if at_tag else f"{field.home}/phone")
    mayday = page.get_by_role("button", name="MAYDAY")
    expect(mayday).to_be_in_viewport(ratio=1, timeout=SOON_MS)
    page.evaluate(FAR_DOWN)
    expect(mayday).to_be_in_viewport(ratio=1)
    with field.api as api:
        api.post("/evacuation").raise_for_status()
        alarm = page.get_by_role("alert").filter(has_text=re.compile("EVACUATE"))
        expect(alarm).to_be_in_viewport(ratio=1, timeout=SOON_MS)  # and spoken, as a role alert that appears
        page.evaluate(FAR_DOWN)
        assert page.evaluate("scrollY") > 0
        expect(alarm).to_be_in_viewport(ratio=1)
        heard = alarm.get_by_role("button", name="I have heard it")
        assert (heard.bounding_box() or {"height": 0})["height"] >= 64
        heard.click(timeout=SOON_MS)
        expect(heard).to_have_count(0)
        expect(alarm).to_be_in_viewport(ratio=1)
        expect(alarm).not_to_contain_text("as soon as there is signal", timeout=SOON_MS)
        assert [who["name"] for who in api.get("/evacuation").json()["acknowledged"]] == ["operator"]
        api.delete("/evacuation").raise_for_status()
        expect(alarm).to_have_count(0, timeout=SOON_MS)


SIGNALS = """
  globalThis.signals = [];
  navigator.vibrate = (pattern) => signals.push(pattern.join()) > 0;
  const frequency = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (...given) {
    signals.push(this.frequency.value);
    return frequency.apply(this, given);
  };
  globalThis.hide = (isHidden) => {
    const value = isHidden ? "hidden" : "visible";
    Object.defineProperty(document, "visibilityState", { value, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
  };
  navigator.wakeLock.request = async () => {
    signals.push("awake");
    return { released: false, release: async () => signals.push("asleep") };
  };
"""


def test_evacuate_is_heard_and_felt_and_stays_until_the_server_says_that_it_is_over(
    field: Field, context: BrowserContext, page: Page
) -> None:
    context.add_init_script(SIGNALS)
    first, second = field.links[0]
    page.goto(f"{field.home}/t/{first}")
    expect(page.get_by_role("button", name="MAYDAY")).to_be_visible(timeout=SOON_MS)
    page.get_by_role("button", name=f"Victim {field.victim}").click()
    page.wait_for_function("() => signals.includes('awake')")  # while somebody is led
    page.get_by_role("button", name="Stop leading me").click()
    page.wait_for_function("() => signals.includes('asleep')")
    keep(page)
    page.evaluate("() => hide(true)")  # in another window, but alive
    with field.api as api:
        api.post("/evacuation").raise_for_status()
        since = api.get("/evacuation").json()["since_unix_s"]
    page.wait_for_function("() => signals.includes('500,250,500,250,500')", timeout=SOON_MS)
    assert page.evaluate("signals.filter((one) => one === 880).length") == 3
    page.evaluate("() => hide(false)")
    heard = page.locator("#alarm").get_by_role("button", name="I have heard it")
    context.set_offline(True)
    alarm = page.get_by_role("alert").filter(has_text=re.compile("EVACUATE"))
    page.get_by_role("button", name="Leave word here").click()
    page.get_by_role("button", name="Searched").click()  # the phone reckons anew with what it carries
    expect(page.get_by_text("Searched left at tag")).to_be_visible()
    expect(alarm).to_be_visible()
    page.goto(f"{field.home}/t/{second}")  # the worker's page, the pocket from before the order
    expect(alarm).to_be_visible(timeout=SOON_MS)
    heard.click()
    expect(alarm).to_contain_text("as soon as there is signal")
    page.goto(f"{field.home}/t/{first}")
    expect(alarm).to_contain_text("as soon as there is signal", timeout=SOON_MS)
    context.set_offline(False)
    with field.api as api:
        api.delete("/evacuation").raise_for_status()
        expect(alarm).to_have_count(0, timeout=SOON_MS)
        page.reload()  # what the phone carries may still say that it holds
        expect(page.get_by_role("button", name="MAYDAY")).to_be_visible(timeout=SOON_MS)
        expect(alarm).to_have_count(0)
        api.post("/evacuation").raise_for_status()
        assert api.get("/evacuation").json()["since_unix_s"] > since
        expect(heard).to_be_visible(timeout=SOON_MS)  # another order is heard by itself
        api.delete("/evacuation").raise_for_status()
        for note in api.get("/annotations").json()["annotations"]:
            api.delete(f"/annotations/{note['annotation_id']}")


FULL = """
  Storage.prototype.setItem = () => { throw new DOMException("no room", "QuotaExceededError"); };
"""


def test_a_full_storage_does_not_stop_leading(field: Field, context: BrowserContext, page: Page) -> None:
    context.add_init_script(FULL)
    page.goto(f"{field.home}/t/{field.links[0][0]}")
    expect(page.get_by_role("button", name="MAYDAY")).to_be_visible(timeout=SOON_MS)
    page.get_by_role("button", name=f"Victim {field.victim}").click()
    expect(page.get_by_role("button", name="Stop leading me")).to_be_visible()
    page.get_by_label("The number on the tag").fill(field.links[0][1])
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("heading", name=f"Tag {field.links[0][1]}")).to_be_visible()
    expect(page.get_by_role("button", name="Stop leading me")).to_be_visible()
    page.get_by_role("button", name="Stop leading me").click()
    expect(page.get_by_role("button", name="Stop leading me")).to_have_count(0)
