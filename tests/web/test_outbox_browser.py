"""Reports over a link that fails in every way: none lost, none doubled, the most important first."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext

from server.app import create_app
from server.benchmarks import outbox
from server.settings import Settings

SEQUENCES = 12
ADD = """async ([kind, body]) => {
  const { add } = await import("/static/phone/outbox.js");
  return (await add(kind, "field", body)).id;
}"""


@pytest.fixture
def home(serve: Any, tmp_path: Path) -> str:
    return f"http://{serve(create_app(Settings(data_dir=tmp_path, login='off')))}"


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(service_workers="block", locale="en-GB")
    yield context
    context.close()


def test_no_report_is_lost_or_doubled(home: str, context: BrowserContext) -> None:
    tally = outbox.run(context, home, SEQUENCES, seed=1)
    assert len(tally.made) > SEQUENCES
    assert min(tally.faults[name] for name in ("lost on the way there", "lost on the way back", "reload")) > 0
    assert tally.lost == []
    assert tally.doubled == []
