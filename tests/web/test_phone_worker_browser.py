"""The phone's service worker: it writes the answer into the page."""

from __future__ import annotations

import json
import re
import time

import httpx
from playwright.sync_api import BrowserContext, expect

from server.benchmarks.browser import OWN_MODULE
from tests.web.field import Field, keep

SOON_MS = 60_000
WORDS = "() => JSON.parse(document.getElementById('told').textContent || 'null')"
WITH_NAME = """async (name) => {
  const { all, put } = await OWN("/static/phone/kept.js");
  const [item] = await all("pockets");
  await put("pockets", { ...item, text: JSON.stringify({ ...JSON.parse(item.text), mission_name: name }) });
}""".replace("OWN", OWN_MODULE)
SPOKEN = """async (language) => {
  const { get } = await OWN("/static/phone/kept.js");
  while ((await get("facts", "language"))?.value !== language) await new Promise(requestAnimationFrame);
}""".replace("OWN", OWN_MODULE)


def test_the_worker_writes_into_the_page_what_the_server_would(field: Field, context: BrowserContext) -> None:
    tag = field.links[0][0]
    page = context.new_page()
    page.goto(f"{field.home}/phone")
    keep(page)
    hostile = "</script><img src=x onerror=alert(1)><!-- $& $` \u2028 \" \\ '"
    context.set_offline(True)
    page.evaluate(WITH_NAME, hostile)
    for language in ("en", "de"):
        page.evaluate(SPOKEN, language)
        page.goto(f"{field.home}/t/{tag}?mission=drill")
        told = page.evaluate(WORDS)
        answer = httpx.get(f"{field.home}/t/{tag}", headers={"Accept-Language": language})
        (served,) = re.findall(r'id="told">(.*?)</script>', answer.text)
        assert (told["language"], told["words"]) == (language, json.loads(served)["words"])
        assert told["where"]["mission_name"] == hostile
        assert time.time() - 600 < told["as_of_s"] < time.time() + 1
        expect(page.locator("h1")).to_have_text(told["words"]["title"])
        expect(page.get_by_text("onerror=alert(1)")).to_be_visible(timeout=SOON_MS)
        assert page.locator("img").count() == 0
        if language == "en":
            page.get_by_role("button", name="Deutsch").click()
    for other in ("/t/nowhere", f"/t/{tag}?mission=other", "/phone"):
        page.goto(f"{field.home}{other}")
        assert page.evaluate(WORDS) is None, other
