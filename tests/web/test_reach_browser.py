"""Asking the server over a network that is slow, or falls silent: given up by silence, not by length."""

from __future__ import annotations

import asyncio
import queue
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.responses import StreamingResponse
from playwright.sync_api import Browser, Page

from web.mount import mount_web

ALMOST_MS, TOO_LONG_MS = 7000, 9000
ASK = """async () => {
  const { ask, reach } = await import("/static/phone/reach.js");
  Object.assign(globalThis, { reach, got: "", end: "" });
  const read = async (response) => {
    const pieces = response.body.pipeThrough(new TextDecoderStream()).getReader();
    for (let next = await pieces.read(); !next.done; next = await pieces.read()) globalThis.got += next.value;
    globalThis.end = "whole";
  };
  ask("GET", "/pieces").then(read).catch(() => { globalThis.end = "given up"; });
}"""


@pytest.fixture
def pieces() -> queue.Queue[str]:
    """What the server sends, each piece when it is put here; an empty one ends it."""
    return queue.Queue()


@pytest.fixture
def page(browser: Browser, serve: Any, pieces: queue.Queue[str]) -> Iterator[Page]:
    app = FastAPI()

    async def sent() -> AsyncIterator[str]:
        while piece := await asyncio.to_thread(pieces.get):
            yield piece

    app.get("/api/v1/pieces")(lambda: StreamingResponse(sent()))
    mount_web(app)
    context = browser.new_context()
    page = context.new_page()
    page.clock.install(time=0)
    page.goto(f"http://{serve(app)}/static/logo.svg")
    page.clock.pause_at(3_600_000)  # from now on time passes only where it is told to
    yield page
    context.close()
    pieces.put("")


def test_what_comes_slowly_is_waited_for_however_long_it_takes(page: Page, pieces: queue.Queue[str]) -> None:
    page.evaluate(ASK)
    for k in range(1, 6):  # 35 s in all
        pieces.put("x")
        page.wait_for_function(f"() => got.length === {k}")
        page.clock.run_for(ALMOST_MS)
    pieces.put("")
    page.wait_for_function("() => end")
    assert page.evaluate("[got, end]") == ["xxxxx", "whole"]


@pytest.mark.parametrize("before", [0, 2])
def test_silence_is_given_up(page: Page, pieces: queue.Queue[str], before: int) -> None:
    page.evaluate(ASK)
    for k in range(before):
        pieces.put("x")
        page.wait_for_function(f"() => got.length === {k + 1}")
    page.clock.run_for(TOO_LONG_MS)
    page.wait_for_function("() => end")
    assert page.evaluate("end") == "given up"
