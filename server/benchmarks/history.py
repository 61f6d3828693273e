"""A mission's past: what recording costs, how large it becomes, and how a browser scrubs through it."""

from __future__ import annotations

import asyncio
import random
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from db.records import MissionRecord
from db.store import Store
from server.benchmarks.browser import CannotMeasureError, chromium, server_process
from server.benchmarks.past_mission import TICK_S, PastMission
from server.board import Board
from server.history.past import Past
from server.history.recorder import Recorder
from server.map_image import MapImage, draw

_MISSION = "bench"
_LOOKS = 40
_SCRUB = """async (shares) => {
  const slider = document.querySelector("#time input");
  const clock = () => [...document.querySelectorAll(".bar-figure")]
    .find((figure) => figure.textContent.startsWith("Mission clock")).querySelector("dd").textContent;
  const waits = [], gaps = [];
  let last = performance.now(), on = true;
  const frame = () => {
    const now = performance.now();
    gaps.push(now - last);
    last = now;
    if (on) requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  for (const share of shares) {
    const before = clock(), from = performance.now();
    slider.value = String(share * Number(slider.max));
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    while (clock() === before && performance.now() - from < 5000) await new Promise(requestAnimationFrame);
    waits.push(performance.now() - from);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  on = false;
  return { waits, gaps };
}"""
_DRAG = """async (steps) => {
  const slider = document.querySelector("#time input");
  const gaps = [];
  let last = performance.now();
  for (let step = 0; step <= steps; step += 1) {
    slider.value = String((step / steps) * Number(slider.max));
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await new Promise(requestAnimationFrame);
    gaps.push(performance.now() - last);
    last = performance.now();
  }
  return gaps;
}"""


def measure(robots: int = 12, minutes: float = 20.0) -> dict[str, Any]:
    """Return milliseconds, bytes and shares of one core; what a browser does only where there is one."""
    with tempfile.TemporaryDirectory(prefix="waymark-bench-") as folder:
        target = Path(folder) / "waymark.db"
        found = asyncio.run(_record(target, robots, minutes))
        try:
            with server_process(folder) as home, chromium() as browser:
                found |= _scrub(browser, home)
        except CannotMeasureError as error:
            found["browser"] = str(error)
    return found


async def _record(target: Path, robots: int, minutes: float) -> dict[str, Any]:
    store = await Store.open(target)
    begun_s = time.time() - 60.0 * minutes
    await store.missions.create_mission(MissionRecord(_MISSION, "Bench", "running", begun_s))
    team, board = PastMission(robots), Board()
    now_s, image = begun_s, draw(team.grid(0))
    recorder = Recorder(store, _MISSION, board, lambda: image, lambda: now_s)
    flush_s: list[float] = []
    for passed_s, values in team.ticks(minutes):
        now_s = begun_s + passed_s
        if passed_s % 5.0 == 0.0:
            image = draw(team.grid(int(1000 * now_s)))
            values["map"] = _map_value(image)
        board.publish(values)
        began = time.process_time()
        await recorder.flush()
        flush_s.append(time.process_time() - began)
    recorder.begin()
    await recorder.close()
    past = Past(store, _MISSION)
    chunks = [len(chunk) async for chunk in past.chunks()]
    looks_ms: list[float] = []
    work_ms: list[float] = []
    for look in range(_LOOKS):
        began, worked = time.perf_counter(), time.process_time()
        await past.state_at(begun_s + 60.0 * minutes * random.Random(look).random())
        looks_ms.append(1000.0 * (time.perf_counter() - began))
        work_ms.append(1000.0 * (time.process_time() - worked))
    whole = await store.history.bytes_of(_MISSION)
    await store.close()
    return {
        "robots": robots,
        "minutes": minutes,
        "recording_share_of_a_core": float(np.mean(flush_s)) / TICK_S,
        "whole_mb": whole / 1e6,
        "chunks_mb": sum(chunks) / 1e6,
        "largest_chunk_kb": max(chunks) / 1e3,
        "state_at_processor_ms": float(np.median(work_ms)),
        "state_at_median_ms": float(np.median(looks_ms)),
        "state_at_longest_ms": max(looks_ms),
    }


def _scrub(browser: Any, home: str) -> dict[str, Any]:
    page = browser.new_page(viewport={"width": 1366, "height": 768})
    page.goto(f"{home}/console?mission={_MISSION}")
    page.wait_for_selector("#time input", timeout=60_000)
    shares = [random.Random(k).random() for k in range(_LOOKS)]
    jumps = page.evaluate(_SCRUB, shares)
    gaps = page.evaluate(_DRAG, 600)
    page.close()
    return {
        "jump_median_ms": float(np.median(jumps["waits"])),
        "jump_p95_ms": float(np.quantile(jumps["waits"], 0.95)),
        "jump_longest_ms": max(jumps["waits"]),
        "drag_frame_median_ms": float(np.median(gaps)),
        "drag_frame_p95_ms": float(np.quantile(gaps, 0.95)),
        "drag_frame_longest_ms": max(gaps),
    }


def _map_value(image: MapImage) -> dict[str, Any]:
    return {
        "version": image.version,
        "width": image.width,
        "height": image.height,
        "resolution_m": image.resolution_m,
        "origin_m": list(image.origin_m),
        "explored_m2": image.explored_m2,
        "png": "",
    }
