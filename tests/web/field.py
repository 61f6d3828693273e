"""A mission in which a robot passed tags and saw a victim, for tests of the phone."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import httpx
from playwright.sync_api import Page

from robots.sim.wire import observation_to_wire

START = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.4, "sd_m": 0.05, "sd_rad": 0.01}
CONFIG = {"deployment": {"spacing_m": 2.0, "rate_per_m": 3.0}}


@dataclass(frozen=True)
class Field:
    """Where it is served, the pairs of tags driven one after the other, and the victim."""

    host: str
    links: list[list[str]]
    victim: str

    @property
    def home(self) -> str:
        return f"http://{self.host}"

    @property
    def api(self) -> httpx.Client:
        return httpx.Client(base_url=f"{self.home}/api/v1/missions/drill", timeout=90)


def drive(host: str, log: Any) -> Field:
    """Open the mission ``drill`` at a server and send a robot's log to it."""
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        return drive_as(client, host, log)


def drive_as(client: httpx.Client, host: str, log: Any) -> Field:
    """Open the mission ``drill`` and send a robot's log to it as somebody who may."""
    words: dict[str, Any] = {"name": "Drill", "mission_id": "drill", "tag_key": ""}
    client.post("/missions", json=words).raise_for_status()
    words = {"robot_id": "r1", "config": CONFIG, "start_pose": START}
    client.post("/missions/drill/robots", json=words).raise_for_status()
    wires = [observation_to_wire(observation) for observation in log.observations]
    for k in range(0, len(wires), 100):
        body = {"observations": wires[k : k + 100]}
        client.post("/missions/drill/robots/r1/observations", json=body).raise_for_status()
    deadline = time.monotonic() + 90.0
    while True:
        victims = client.get("/missions/drill/victims").json()["victims"]
        links = client.get("/missions/drill/tags").json()["links"]
        if victims and len(links) > 1:
            return Field(host, links, victims[0]["victim_id"])
        assert time.monotonic() < deadline, (victims, links)
        time.sleep(0.1)


def keep(page: Page) -> None:
    """Wait until the page and a mission are on the phone."""
    page.evaluate("() => navigator.serviceWorker.ready")
    page.wait_for_function("async () => (await caches.keys()).length === 2")
    kept = "import('/static/phone/kept.js').then(({ all }) => all('pockets')).then((all) => all.length > 0)"
    page.wait_for_function(f"() => {kept}")
