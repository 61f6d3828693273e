"""The phone's page over a slow network: until it answers, has the whole mission, and opens without signal."""

from __future__ import annotations

import json
import socket
import sys
import tempfile
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from subprocess import DEVNULL, Popen
from typing import Any

from server.benchmarks.browser import OWN_MODULE, wait_for
from server.benchmarks.phone_server import MISSION
from server.benchmarks.slow_network import slow_network

TAGS = 5000
_BITS_PER_S, _THERE_AND_BACK_S = 1e6, 0.1
_NOTE = "00000000-0000-4000-8000-00000000beef"
_ANSWERED = "() => document.querySelector('.where') && performance.now()"
_KEPT = """async () => {
  const { all } = await OWN("/static/phone/kept.js");
  while (!(await all("pockets")).length) await new Promise((done) => setTimeout(done, 50));
  return performance.now();
}""".replace("OWN", OWN_MODULE)
_OPENS_ALONE = """async () => {
  await navigator.serviceWorker.ready;
  while (!navigator.serviceWorker.controller) await new Promise((done) => setTimeout(done, 50));
  return performance.now();
}"""
_NEWEST = """async (from) => {
  const isNewest = ({ name, startTime, responseStatus }) =>
    name.includes("/pocket") && startTime > from && responseStatus === 200;
  for (;;) {
    const fetched = performance.getEntriesByType("resource").find(isNewest);
    if (fetched) return [fetched.duration, fetched.encodedBodySize / 1000];
    await new Promise((done) => setTimeout(done, 50));
  }
}"""


def measure(browser: Any, home: str, mission: str, tag: str, slower: int) -> dict[str, float]:
    """Return seconds since a touch at 1 Mbit/s and 100 ms, in a browser (Playwright) new to the page.

    ``slower``: by how much its processor is slowed down.
    """
    with slow_network(home.removeprefix("http://"), _BITS_PER_S, _THERE_AND_BACK_S) as host:
        context = browser.new_context(viewport={"width": 390, "height": 844})
        page = context.new_page()
        context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": slower})
        page.goto(f"http://{host}/t/{tag}", wait_until="commit")
        answered = page.wait_for_function(_ANSWERED, polling=20, timeout=120_000).json_value()
        kept = page.evaluate(_KEPT)
        alone = page.evaluate(_OPENS_ALONE)
        _leave_note(home, mission)
        again, size = page.evaluate(_NEWEST, alone)  # the page asks for it by itself
        context.close()
    return {
        "first answer, s": answered / 1000.0,
        "whole mission on the phone, s": kept / 1000.0,
        "opens without signal, s": alone / 1000.0,
        "a note by others: fetching it, s": again / 1000.0,
        "a note by others: fetched, kB": size,
    }


@contextmanager
def large_mission() -> Iterator[tuple[str, str]]:
    """Serve a mission of 5,000 tags; its address and its name."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    with tempfile.TemporaryDirectory(prefix="waymark-bench-") as folder:
        arguments = [sys.executable, "-m", "server.benchmarks.phone_server", port, folder, str(TAGS)]
        process = Popen(arguments, stdout=DEVNULL, stderr=DEVNULL)
        try:
            wait_for(f"http://127.0.0.1:{port}")
            yield f"http://127.0.0.1:{port}", MISSION
        finally:
            process.terminate()
            process.wait()


def _leave_note(home: str, mission: str) -> None:
    request = urllib.request.Request(
        f"{home}/api/v1/missions/{mission}/annotations/{_NOTE}",
        data=json.dumps({"kind": "note", "text": "stairs", "x_m": 1.0, "y_m": 1.0}).encode(),
        method="PUT",
        headers={"Content-Type": "application/json"},
    )
    urllib.request.urlopen(request, timeout=30).close()
