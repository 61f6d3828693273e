"""What the phone says: every language has every text, and says ways as the server does."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from robots.routes.texts import TEXTS
from server.app import create_app
from server.settings import Settings
from web.mount import mount_web

Tables = dict[str, dict[str, Any]]


@pytest.fixture
def tables(browser: Browser, serve: Any) -> Iterator[Tables]:
    app = FastAPI()
    mount_web(app)
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"http://{serve(app)}/static/logo.svg")
    yield page.evaluate(
        """async () => {
          const { LANGUAGES } = await import("/static/phone/texts.js");
          return Object.fromEntries(Object.entries(LANGUAGES).map(([name, { texts }]) => [name, texts]));
        }"""
    )
    context.close()


def values(text: str | dict[str, str]) -> set[str]:
    parts = [text] if isinstance(text, str) else list(text.values())
    return {name for part in parts for name in re.findall(r"\{(\w+)\}", part)}


def test_every_language_has_every_text_with_the_same_values(tables: Tables) -> None:
    assert sorted(tables) == ["de", "en"]
    assert tables["de"].keys() == tables["en"].keys()
    for key, english in tables["en"].items():
        german = tables["de"][key]
        assert isinstance(german, str) == isinstance(english, str), key
        assert values(german) == values(english), key
        parts = [german] if isinstance(german, str) else list(german.values())
        assert all(part.strip() for part in parts), key


def test_the_phone_says_ways_as_the_server_does(tables: Tables) -> None:
    for language, texts in TEXTS.items():
        for key, text in texts.items():
            name, _, form = key.partition(".")
            said = tables[language][name]
            assert (said[form] if form else said) == text, (language, key)


def test_a_phone_speaks_its_owners_language_until_told_otherwise(
    browser: Browser, serve: Any, tmp_path: Any
) -> None:
    host = serve(create_app(Settings(data_dir=tmp_path, login="off")))
    context = browser.new_context(locale="de-AT", viewport={"width": 390, "height": 844})
    page: Page = context.new_page()
    page.goto(f"http://{host}/t")
    expect(page.get_by_role("heading", name="Welche Marke?")).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == "de"
    page.get_by_role("button", name="English").click()
    expect(page.get_by_role("heading", name="Which tag?")).to_be_visible()
    page.reload()
    expect(page.get_by_role("heading", name="Which tag?")).to_be_visible()
    assert page.evaluate("document.documentElement.lang") == "en"
    page.get_by_role("button", name="Deutsch").click()
    expect(page.get_by_role("heading", name="Welche Marke?")).to_be_visible()
    context.close()
