"""Serving an application on a free loopback port for a test, and a browser to look at it."""

from __future__ import annotations

import asyncio
import os
import shutil
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
import uvicorn
from fastapi import FastAPI
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

from robots.sim.wire import observation_to_wire
from server.app import create_app
from server.settings import Settings
from tests.web.field import Field, drive

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-background-networking", "--disable-component-update",
    "--disable-default-apps", "--disable-sync", "--no-first-run",
]  # fmt: skip


expect.set_options(timeout=30_000)  # five seconds are too few where a machine does other things, too


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
        self.thread.join(timeout=60)
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


@pytest.fixture(scope="module")
def drill(tmp_path_factory: pytest.TempPathFactory, robot_log: Any) -> Iterator[dict[str, Any]]:
    """A mission with tags: the application, the host that serves it, and their ids."""
    serve = Serve()
    folder = tmp_path_factory.mktemp("drill")
    app = create_app(Settings(data_dir=folder, login="off", reply_s=60.0))
    host = serve(app)
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        client.post(
            "/missions", json={"name": "Drill", "mission_id": "drill", "tag_key": ""}
        ).raise_for_status()
        client.post("/missions/drill/robots", json={"robot_id": "r1"}).raise_for_status()
        wires = [observation_to_wire(observation) for observation in robot_log.observations[:300]]
        for k in range(0, len(wires), 100):
            body = {"observations": wires[k : k + 100]}
            client.post("/missions/drill/robots/r1/observations", json=body).raise_for_status()
        for _ in range(600):
            tags = client.get("/missions/drill/tags").json()["tags"]
            if tags:
                break
            time.sleep(0.1)
    yield {"app": app, "host": host, "tags": [tag["tag_id"] for tag in tags]}
    serve.close()


@pytest.fixture(scope="module")
def field(tmp_path_factory: pytest.TempPathFactory, robot_log: Any) -> Iterator[Field]:
    """The mission that phones walk through."""
    serve = Serve()
    settings = Settings(data_dir=tmp_path_factory.mktemp("field"), login="off", reply_s=60.0)
    yield drive(serve(create_app(settings)), robot_log)
    serve.close()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    """A phone."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, locale="en-GB")
    yield context
    context.close()


@pytest.fixture
def page(context: BrowserContext) -> Page:
    return context.new_page()
