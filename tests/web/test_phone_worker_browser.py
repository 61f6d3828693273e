"""The phone's service worker: it writes the answer into the page, and takes a new version whole."""

from __future__ import annotations

import json
import re
import shutil
import time
from pathlib import Path
from typing import Any

import httpx
from fastapi import FastAPI, Request
from fastapi.responses import Response
from playwright.sync_api import Browser, BrowserContext, expect

from server.benchmarks.browser import OWN_MODULE
from tests.web.field import Field, keep
from web.bundle import Sources
from web.made import Made
from web.mount import NODE_MODULES, SECURITY_HEADERS, STATIC, VENDOR_FILES
from web.shell import PAGE, shell

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


def test_a_new_version_takes_the_place_of_the_old_one(browser: Browser, serve: Any, tmp_path: Path) -> None:
    static = tmp_path / "static"
    shutil.copytree(STATIC, static)
    sources = Sources(static, {name: NODE_MODULES / file for name, file in VENDOR_FILES.items()})
    made = Made(sources, SECURITY_HEADERS)
    app = FastAPI()

    @app.get("/{path:path}")
    def file(request: Request, path: str) -> Response:
        ready = made.find(PAGE if path.startswith("t/") else f"/{path}")
        if ready is not None:
            return ready.response(request)
        held = shell(sources).files.get(f"/{path}")
        return Response(held) if held is not None else Response(status_code=404)

    home = f"http://{serve(app)}"
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"{home}/phone")
    page.wait_for_function("async () => (await caches.keys()).length === 2", timeout=SOON_MS)
    before = page.evaluate("caches.keys()")
    address = static / "phone" / "address.js"
    address.write_text("const NEW = 1;\n" + address.read_text())
    page.goto(f"{home}/phone")
    page.wait_for_function(
        """async (before) => {
          const now = await caches.keys();
          return now.length === 2 && !now.some((name) => before.includes(name));
        }""",
        arg=before,
        timeout=SOON_MS,
    )
    context.set_offline(True)
    for path in ("/t/A1", "/phone"):
        page.goto(f"{home}{path}")
        expect(page.get_by_role("button", name="MAYDAY")).to_be_visible(timeout=SOON_MS)  # all of its scripts
        assert "const NEW = 1;" in page.content(), path
    context.close()
