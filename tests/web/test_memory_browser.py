"""The phone reads tags' memories as the Python codec does: the same vectors, in a real browser."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page

from tests.vectors.tag_memories import FILE
from web.mount import mount_web

READ = """async (vectors) => {
  const { memoryOnChip, sentencesOf } = await import("/static/phone/memory.js");
  return vectors.map(({ payload, size }) => {
    const bytes = new Uint8Array(size);
    bytes.set(payload.match(/../g)?.map((byte) => parseInt(byte, 16)) ?? []);
    const { condition, memory } = memoryOnChip(bytes);
    return { condition, memory, sentences: memory ? sentencesOf(memory, null) : [] };
  });
}"""


TURNED = """async () => {
  const { decodeMemory, sentencesOf } = await import("/static/phone/memory.js");
  const victims = [{ key: 1, north_m: 3, west_m: -1.5, confidence: 0.8, seen_min: 12 }];
  const memory = { ...decodeMemory(new Uint8Array()), victims };
  return [null, 0, 90, 180].map((north) => sentencesOf(memory, north)[0]);
}"""


@pytest.fixture
def page(browser: Browser, serve: Any) -> Iterator[Page]:
    app = FastAPI()
    mount_web(app)
    context = browser.new_context(locale="en-GB")
    page = context.new_page()
    page.goto(f"http://{serve(app)}/static/logo.svg")  # any page of the server's
    yield page
    context.close()


def test_the_phone_reads_every_vector_as_python_does(page: Page) -> None:
    vectors = json.loads(FILE.read_text())
    asked = [{name: vector[name] for name in ("payload", "size")} for vector in vectors]
    for vector, found in zip(vectors, page.evaluate(READ, asked), strict=True):
        name = vector["name"]
        if vector["condition"] == "unreadable":
            assert found["condition"] in ("damaged", "foreign"), name
            assert found["memory"] is None, name
        else:
            assert found["condition"] == vector["condition"], name
            assert found["memory"] == vector["memory"], name
            assert found["sentences"] == vector["sentences"], name
        if found["condition"] == "foreign":
            assert name.startswith(("of version", "of somebody", "sealed nonsense"))


def test_places_in_a_memory_are_turned_to_true_north_where_that_is_known(page: Page) -> None:
    assert page.evaluate(TURNED) == [
        f"Victim 0001: {way} of the tag, 80% sure, seen at minute 12."
        for way in (
            "3.0 m plan north and 1.5 m plan east",
            "3.0 m north and 1.5 m east",
            "1.5 m south and 3.0 m east",
            "3.0 m south and 1.5 m west",
        )
    ]
