"""The phone's page: from a touch to the answer, with signal and without, and how much it has to load."""

from __future__ import annotations

import gzip
import json
import time
import urllib.request
from statistics import median
from typing import Any

import numpy as np

from robots.routes.planner import RouteMap
from robots.routes.ways import Way
from robots.sim.live import play
from robots.sim.scenario import ScenarioConfig
from server.benchmarks import phone_network
from server.benchmarks.browser import OWN_MODULE, chromium, server_process
from web.bundle import Sources
from web.mount import NODE_MODULES, STATIC, VENDOR_FILES
from web.shell import PAGE, shell

_MISSION, _TIMES, _SLOWER = "bench", 15, 4
_STOPS_S = 0.3
_ANSWERED = """
  new MutationObserver((_, observer) => {
    if (!document.querySelector(".where")) return;
    observer.disconnect();
    requestAnimationFrame(() => setTimeout(() => console.info(`answered ${performance.now()}`)));
  }).observe(document, { childList: true, subtree: true });
"""
_TOUCH = """async (tag) => {
  const { touch } = await OWN("/static/phone/touch.js");
  const from = performance.now();
  touch(tag);
  const title = () => document.querySelector("h1")?.textContent;
  const isThere = () => title() === `Tag ${tag}` && document.querySelector(".where");
  while (!isThere()) await new Promise(requestAnimationFrame);
  return performance.now() - from;
}""".replace("OWN", OWN_MODULE)
_KEPT = """async () => (await import("/static/phone/kept.js")).all("pockets").then((all) => all.length > 0)"""
_ROUTES = """async ([pocket, pairs]) => {
  const { Roads } = await OWN("/static/phone/roads.js");
  const { routeTo } = await OWN("/static/phone/where.js");
  const from = performance.now();
  const roads = new Roads(pocket);
  const ready = performance.now();
  for (const [a, b] of pairs) routeTo(pocket, roads, a, b);
  return [ready - from, (performance.now() - ready) / pairs.length];
}""".replace("OWN", OWN_MODULE)


def measure() -> dict[str, Any]:
    """Return median times in milliseconds and sizes in kilobytes.

    Raises:
        CannotMeasureError: there is no browser here.
    """
    with server_process() as home, chromium() as browser:
        config = ScenarioConfig(map="office:200", robots=2, minutes=1.5, seed=1)
        play(config, home, _MISSION, speed=4.0)
        tags = _tags(home)
        found: dict[str, Any] = {"tags": len(tags)} | sizes()
        found["touch to answer, never seen, online, ms"] = median(_first(browser, home, tag) for tag in tags)
        context = browser.new_context(viewport={"width": 390, "height": 844})
        context.add_init_script(_ANSWERED)
        page = context.new_page()
        page.goto(f"{home}/phone")
        page.evaluate("() => navigator.serviceWorker.ready")
        page.wait_for_function("async () => (await caches.keys()).length === 2")
        page.wait_for_function(_KEPT)
        devtools = context.new_cdp_session(page)
        devtools.send("Emulation.setCPUThrottlingRate", {"rate": _SLOWER})
        for word in ("online", "offline"):
            context.set_offline(word == "offline")
            found[f"touch to answer, page opened, {word}, ms"] = _opened(page, home, tags)
            found[f"touch to answer, page open, {word}, ms"] = median(page.evaluate(_TOUCH, t) for t in tags)
        found["touch to answer, page and worker opened, offline, ms"] = _opened_cold(
            page, devtools, home, tags
        )
        found |= _routes(page)
        context.close()
        found |= _over_a_slow_network(browser, home, tags[0])
    return {name: round(value, 1) for name, value in found.items()}


def _over_a_slow_network(browser: Any, home: str, tag: str) -> dict[str, float]:
    of = {"1 Mbit/s": phone_network.measure(browser, home, _MISSION, tag, _SLOWER)}
    with phone_network.large_mission() as (large, mission):
        of["1 Mbit/s, 5,000 tags"] = phone_network.measure(browser, large, mission, "T0", _SLOWER)
    return {f"{where}: {name}": value for where, found in of.items() for name, value in found.items()}


def sizes() -> dict[str, float]:
    """Return sizes, gzipped: the page, which answers; with the script that leads; what it keeps beside."""
    kept = shell(Sources(STATIC, {address: NODE_MODULES / name for address, name in VENDOR_FILES.items()}))
    zipped = {address: len(gzip.compress(data, 9)) / 1000.0 for address, data in kept.files.items()}
    first = zipped[PAGE] + next(size for name, size in zipped.items() if name.endswith("/phone.1.js"))
    return {
        "page that answers, kB gzipped": zipped[PAGE],
        "shell, kB gzipped": first,
        "read on demand, kB gzipped": sum(zipped.values()) - first,
    }


def _tags(home: str) -> list[str]:
    with urllib.request.urlopen(f"{home}/api/v1/missions/{_MISSION}/tags", timeout=30) as response:
        return [tag["tag_id"] for tag in json.loads(response.read())["tags"]][:_TIMES]


def _first(browser: Any, home: str, tag: str) -> float:
    """Return the time to the answer in a browser that has never seen the page."""
    context = browser.new_context(viewport={"width": 390, "height": 844})
    context.add_init_script(_ANSWERED)
    page = context.new_page()
    context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": _SLOWER})
    found = _opened(page, home, [tag])
    context.close()
    return found


def _opened(page: Any, home: str, tags: list[str]) -> float:
    """Return the time from opening the page to its answer.

    The page says so itself: Playwright's ways of waiting bring a script of 330 kB into it, which the slowed
    processor has to read in the middle of what is measured.
    """
    times = []
    for tag in tags:
        with page.expect_console_message(lambda message: message.text.startswith("answered ")) as said:
            page.goto(f"{home}/t/{tag}", wait_until="commit")
        times.append(float(said.value.text.split()[1]))
    return median(times)


def _opened_cold(page: Any, devtools: Any, home: str, tags: list[str]) -> float:
    """Return the time where the browser has stopped the page's worker, as it does after half a minute."""
    devtools.send("ServiceWorker.enable")
    times = []
    for tag in tags:
        devtools.send("ServiceWorker.stopAllWorkers")
        time.sleep(_STOPS_S)
        times.append(_opened(page, home, [tag]))
    return median(times)


def _routes(page: Any) -> dict[str, float]:
    """Return times for routes over a lattice of 5,000 tags, here and on the slowed-down phone."""
    side = 71
    places = {f"T{k}": (3.0 * (k // side), 3.0 * (k % side)) for k in range(5000)}
    pairs = [(f"T{k}", f"T{j}") for k in range(5000) for j in (k + 1, k + side) if j < 5000]
    ways = [Way(a, b, np.array([places[a], places[b]])) for a, b in pairs]
    numbers = {tag: k for k, tag in enumerate(places)}
    tags = [{"tag_id": tag, "x_m": x, "y_m": y, "sd_m": 0.1, "notice": ""} for tag, (x, y) in places.items()]
    packed = [
        [numbers[way.from_tag], numbers[way.to_tag], 300, (100 * way.points_m).ravel().tolist(), 0, 0, 0]
        for way in ways
    ]
    pocket = {
        "tags": tags,
        "ways": packed,
        "victims": [],
        "notes": [],
    }
    rng = np.random.default_rng(1)
    asked = [(f"T{a}", f"T{b}") for a, b in rng.integers(0, 5000, (20, 2))]
    roads = RouteMap(ways)
    start = time.perf_counter()
    for a, b in asked:
        roads.route(a, [b])
    server_ms = 1000.0 * (time.perf_counter() - start) / len(asked)
    ready_ms, route_ms = page.evaluate(_ROUTES, [pocket, [(a, f"tag:{b}") for a, b in asked]])
    return {
        "5,000 tags: route on the server, ms": server_ms,
        "5,000 tags: route on the phone, ms": route_ms,
        "5,000 tags: made ready on the phone, ms": ready_ms,
    }
