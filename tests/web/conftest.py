"""Serving an application on a free loopback port for a test, and a browser to look at it."""

from __future__ import annotations

import asyncio
import os
import shutil
import socket
import threading
from collections.abc import Iterator

import pytest
import uvicorn
from fastapi import FastAPI
from playwright.sync_api import Browser, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update",
    "--disable-default-apps", "--disable-sync", "--no-first-run",
]  # fmt: skip


class _Server:
    """A uvicorn server in a thread of its own."""

    def __init__(self, app: FastAPI):
        self.socket = socket.create_server(("127.0.0.1", 0))
        config = uvicorn.Config(app, log_level="error", ws="websockets-sansio", timeout_graceful_shutdown=1)
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(
            target=lambda: asyncio.run(self.server.serve(sockets=[self.socket])), daemon=True
        )
        self.thread.start()

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.socket.getsockname()[1]}"

    def stop(self) -> None:
        self.server.should_exit = True
        self.thread.join(timeout=10)
        self.socket.close()
        assert not self.thread.is_alive(), "the server did not stop"


class Serve:
    """Serves applications, each in a thread of its own, until the test ends."""

    def __init__(self) -> None:
        self._servers: dict[str, _Server] = {}

    def __call__(self, app: FastAPI) -> str:
        """Serve the application and return its host:port."""
        server = _Server(app)
        self._servers[server.host] = server
        return server.host

    def stop(self, host: str) -> None:
        """Stop what is served at a host:port."""
        self._servers.pop(host).stop()

    def close(self) -> None:
        for host in tuple(self._servers):
            self.stop(host)


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Return a function that serves an application and returns its host:port; all stop at the end."""
    serve = Serve()
    yield serve
    serve.close()


@pytest.fixture(scope="module")  # while it is open no other event loop can run in this thread
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium on this machine: the browser tests cannot run")
        pytest.skip("no Chromium on this machine")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()
