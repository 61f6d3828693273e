"""A browser and a server of our own to measure pages with."""

from __future__ import annotations

import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_FLAGS = ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--no-first-run"]
_STARTS_S = 600.0
OWN_MODULE = """(async (address) => {
  const own = globalThis.modules$;
  while (own && !own[address]) await new Promise((done) => setTimeout(done, 10));
  return own?.[address] ?? import(address);
})"""
"""Script: a function that finds a module: the page's own, once loaded, where it has combined ones."""


class CannotMeasureError(RuntimeError):
    """Something that is measured with is not installed; the message says what to do."""


@contextmanager
def server_process(data: str | None = None, login: str = "off") -> Iterator[str]:
    """Serve a mission control in a process of its own, an empty one without ``data``; its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory(prefix="waymark-bench-") as folder:
        arguments = ["serve", "--port", str(port), "--data", data or folder, "--login", login]
        server = subprocess.Popen(
            [sys.executable, "-m", "server.cli.main", *arguments],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            wait_for(f"http://127.0.0.1:{port}")
            yield f"http://127.0.0.1:{port}"
        finally:
            server.terminate()
            server.wait()


@contextmanager
def chromium(*flags: str) -> Iterator[Any]:
    """Open a headless Chromium (Playwright's ``Browser``), with further flags.

    Raises:
        CannotMeasureError: there is no Chromium here, or no Playwright.
    """
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise CannotMeasureError("this needs Playwright: pip install playwright") from error
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if path is None:
        raise CannotMeasureError("this needs a Chromium: install one (Debian: apt install chromium)")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=[*_FLAGS, *flags])
        try:
            yield browser
        finally:
            browser.close()


def wait_for(url: str) -> None:
    """Wait until a server answers."""
    until = time.monotonic() + _STARTS_S
    while True:
        try:
            urllib.request.urlopen(f"{url}/api/v1/health", timeout=1.0).close()
            return
        except OSError:
            if time.monotonic() > until:
                raise
            time.sleep(0.1)
