"""Between tags, in a real browser: steps counted, and an error that grows and covers the truth."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, degrees, hypot, pi, radians, sin
from typing import Any

import numpy as np
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page

from robots.sim.tags import TagField
from robots.sim.walker import Advice, Gait, Walker
from robots.sim.world import world_of
from web.mount import mount_web

STEP_M = 0.7
MIDDLE_M = 25.0

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


FAR_M = (4, 8, 14, 20)
WALKS = 40
HELD_RAD = radians(9.0)  # between where a phone points and where its owner goes
SHAKE_DEG = 5.0
MISSED = 0.06  # steps in one


def paths(seed: int) -> tuple[list[float], list[tuple[float, float]]]:
    """Let the simulator's person walk away from a tag at the origin.

    Return what their compass shows at each step that is counted, degrees from the plan's north, and where
    they truly are then, m: none where a step is missed, a second one where something else is counted.
    """
    tags = TagField(0)
    tags.drop("A", MIDDLE_M, MIDDLE_M)
    rng = np.random.default_rng([seed, 7])
    x, y = rng.uniform(-0.5, 0.5, 2) + MIDDLE_M
    said = Advice(float(rng.uniform(0.0, 360.0)), f"Go {FAR_M[-1] + 2} m north to tag B.", "B")
    world = world_of(np.zeros((round(20 * MIDDLE_M),) * 2, bool), 0.1)
    walker = Walker(world, tags, (), {"A": said}.get, (x, y), seed, Gait(scale=0.08))
    held_deg, missed = degrees(rng.normal(0, HELD_RAD)), rng.normal(0, MISSED)
    headings: list[float] = []
    truth: list[tuple[float, float]] = []
    feet = was = None
    walked_m = 0.0
    while walker.advance() and STEP_M * len(headings) < FAR_M[-1] + 1:
        if walker.last_tag is None:
            continue
        now = walker.reckoned_m
        feet, was = feet or now, was or now
        walked_m, was = walked_m + hypot(now[0] - was[0], now[1] - was[1]), now
        if walked_m < STEP_M:
            continue
        north, west = now[0] - feet[0], now[1] - feet[1]
        walked_m, feet = walked_m - STEP_M, now
        shown = held_deg - degrees(atan2(west, north)) + rng.normal(0, SHAKE_DEG)
        count = 1 if rng.random() > abs(missed) else 0 if missed > 0 else 2
        headings += [shown] * count
        truth += [(walker.x_m - MIDDLE_M, walker.y_m - MIDDLE_M)] * count
    return headings, truth


def test_the_circle_that_is_drawn_holds_the_truth_as_often_as_two_deviations_should(page: Page) -> None:
    """Of a Gaussian in a plane 86 %, more where its axes differ: neither too few nor nearly all walks."""
    inside = dict.fromkeys(FAR_M, 0)
    for seed in range(WALKS):
        headings, truth = paths(seed)
        places = page.evaluate(WALK, [{"x_m": 0.0, "y_m": 0.0, "sd_m": 0.3}, headings])
        sds = [place["sd_m"] for place in places]
        assert sds == sorted(sds)
        for far_m in FAR_M:
            place, (x, y) = (each[round(far_m / STEP_M)] for each in (places, truth))
            inside[far_m] += hypot(place["x_m"] - x, place["y_m"] - y) <= 2.0 * place["sd_m"]
    share = {far_m: count / WALKS for far_m, count in inside.items()}
    assert all(0.8 <= each <= 0.975 for each in share.values()), share
    assert 0.8 <= sum(share.values()) / len(share) <= 0.97, share
