"""Every state of the phone's page at a phone's size: as axe-core finds it, and as gloves and masks do."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.web.axe import Audit
from tests.web.field import Field, keep

pytestmark = pytest.mark.browser
SOON_MS = 60_000


def test_every_state_can_be_read_and_hit(field: Field, context: BrowserContext, page: Page) -> None:
    audit = Audit(page)
    page.goto(f"{field.home}/t")
    expect(page.get_by_role("button", name="Scan a label")).to_be_visible(timeout=SOON_MS)
    audit.look_in_gloves("no tag yet")
    page.get_by_label("The number on the tag").fill("nowhere")
    page.get_by_role("button", name="Where am I?").click()
    expect(page.get_by_role("alert")).to_be_visible(timeout=SOON_MS)
    audit.look_in_gloves("a wrong number")

    page.goto(f"{field.home}/t/{field.links[0][0]}")
    keep(page)
    expect(page.get_by_role("button", name="Leave word here")).to_be_visible(timeout=SOON_MS)
    audit.look_in_gloves("at a tag")
    _leave_word(page, audit)
    page.get_by_role("button", name=f"Victim {field.victim}").click()
    expect(page.locator(".go .number")).to_be_visible(timeout=SOON_MS)
    audit.look_in_gloves("led to a victim")
    _call_without_signal(field, context, page, audit)

    page.get_by_role("button", name="Deutsch").click()
    expect(page.get_by_role("button", name="Hier etwas hinterlassen")).to_be_visible()
    audit.look_in_gloves("led, in German")
    page.get_by_role("button", name="Hier etwas hinterlassen").click()
    audit.look_in_gloves("leaving word, in German")
    assert not audit.found, "\n".join(audit.found)


def _leave_word(page: Page, audit: Audit) -> None:
    page.get_by_role("button", name="Leave word here").click()
    expect(page.get_by_label("What is here")).to_be_visible()
    audit.look_in_gloves("leaving word")
    page.locator("form").get_by_role("button", name="Victim").click()
    expect(page.get_by_role("button", name="Leave this")).to_be_visible()
    audit.look_in_gloves("a victim")
    page.get_by_role("button", name="No", exact=True).click()
    expect(page.get_by_role("button", name="Up to 30")).to_be_visible()
    audit.look_in_gloves("a victim, breaths")
    page.get_by_role("button", name="Up to 30").click()
    page.get_by_role("button", name="Yes", exact=True).click()
    page.get_by_role("button", name="No", exact=True).click()
    expect(page.get_by_text("START: immediate, red.")).to_be_visible()
    audit.look_in_gloves("a victim, judged")
    page.get_by_role("button", name="Leave this").click()
    expect(page.get_by_text(re.compile("^Victim left at tag"))).to_be_visible()
    audit.look_in_gloves("word was left")


def _call_without_signal(field: Field, context: BrowserContext, page: Page, audit: Audit) -> None:
    with field.api as api:
        api.post("/evacuation").raise_for_status()
        heard = page.get_by_role("button", name="I have heard it")
        expect(heard).to_be_visible(timeout=SOON_MS)
        audit.look_in_gloves("EVACUATE")
        context.set_offline(True)
        page.get_by_role("button", name="MAYDAY").click(delay=900)
        expect(page.get_by_text("is NOT sent yet")).to_be_visible(timeout=SOON_MS)
        heard.click()
        expect(page.locator("#standing")).to_contain_text("No signal.", timeout=SOON_MS)
        audit.look_in_gloves("MAYDAY waits, EVACUATE heard")
        page.get_by_role("button", name=re.compile("reports wait")).click()
        audit.look_in_gloves("what waits")
        page.get_by_role("button", name="Hand them to another phone").click()
        expect(page.locator(".handover .code")).to_be_visible(timeout=SOON_MS)
        audit.look_in_gloves("handing over")
        context.set_offline(False)
        expect(page.get_by_text("MAYDAY was called")).to_be_visible(timeout=SOON_MS)
        audit.look_in_gloves("MAYDAY was called")
        api.delete("/evacuation").raise_for_status()
        api.delete("/alerts/mayday/operator")
        expect(page.locator("#alarm").get_by_role("alert")).to_have_count(0, timeout=SOON_MS)
