"""Between tags, in a real browser: steps counted, and an error that grows and covers the truth."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, hypot, pi, radians, sin
from typing import Any

import numpy as np
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page

from web.mount import mount_web

COUNT = """async (samples) => {
  const { StepCounter } = await import("/static/phone/between.js");
  const counter = new StepCounter();
  return samples.filter(([ms, x, y, z]) => counter.feel(x, y, z, ms)).length;
}"""
WALK = """async ([tag, headings]) => {
  const { Walk } = await import("/static/phone/between.js");
  const walk = new Walk(tag);
  return headings.map((heading) => { walk.step(heading); return walk.place; });
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


def felt(rng: np.random.Generator, steps: int, hz: float, swing: float) -> list[list[float]]:
    """What a phone feels: gravity, a swing for each step (1.8 a second), a hand that shakes."""
    down = rng.normal(0, 1, 3)
    down /= np.linalg.norm(down)
    samples = []
    for k in range(int((steps / 1.8 + 2.0) * hz)):
        t = k / hz - 1.0
        walks = 0.0 <= t < steps / 1.8
        push = swing * sin(2 * pi * 1.8 * t) if walks else 0.0
        samples.append([1000.0 * k / hz, *(down * (9.81 + push) + rng.normal(0, 0.25, 3)).tolist()])
    return samples


@pytest.mark.parametrize(("hz", "swing"), [(60.0, 3.0), (60.0, 5.0), (30.0, 4.0)])
def test_steps_are_counted_however_the_phone_is_held(page: Page, hz: float, swing: float) -> None:
    rng = np.random.default_rng(2)
    for steps in (10, 40):
        assert abs(page.evaluate(COUNT, felt(rng, steps, hz, swing)) - steps) <= max(1, 0.08 * steps)
    assert page.evaluate(COUNT, felt(rng, 0, hz, swing)) == 0  # standing still


def test_the_error_grows_and_covers_where_people_really_are(page: Page) -> None:
    """Walkers who err as people do are within two standard deviations most of the time."""
    rng = np.random.default_rng(3)
    inside = total = 0
    for _ in range(60):
        length, turned = 0.7 * (1 + rng.normal(0, 0.12)), rng.normal(0, 0.2)
        x, y, headings, truth = 0.0, 0.0, [], []
        heading = rng.uniform(0, 360)
        for _ in range(20):
            heading += rng.normal(0, 10)
            x, y = x + length * cos(radians(heading)), y - length * sin(radians(heading))
            headings.append(heading + np.degrees(turned) + rng.normal(0, 5))
            truth.append((x, y))
        places = page.evaluate(WALK, [{"x_m": 0.0, "y_m": 0.0, "sd_m": 0.3}, headings])
        sds = [place["sd_m"] for place in places]
        assert sds == sorted(sds)
        off = [hypot(p["x_m"] - x, p["y_m"] - y) for p, (x, y) in zip(places, truth, strict=True)]
        inside += sum(gap <= 2.0 * sd for gap, sd in zip(off, sds, strict=True))
        total += len(off)
    assert 0.85 <= inside / total <= 0.999
