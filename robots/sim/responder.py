"""A simulated responder in a live mission: led by mission control from tag to tag to the victims.

They walk in the simulator's world beside the robots, which do not see them, and reach the server as a phone
does: where am I, the way there, and "I am at this tag" at every tag.
"""

from __future__ import annotations

import json
import threading
import time
import urllib.request
from collections.abc import Sequence
from typing import Any
from urllib.parse import quote, urlencode
from uuid import uuid4

from robots.sim.hearing import Device
from robots.sim.simulation import Simulation
from robots.sim.tags import BASE_TAG
from robots.sim.walker import TICK_S, Advice, Fix, Walker

_LOOK_EVERY_S = 3.0
_WITH_VICTIM_S = 20.0
_TIMEOUT_S = 10.0


class Responder:
    """Walks in a thread of its own until ``stop`` is set. ``name``: how their reports are signed."""

    def __init__(
        self,
        simulation: Simulation,
        url: str,
        mission_id: str,
        name: str,
        speed: float,
        stop: threading.Event,
    ) -> None:
        self._simulation, self._name, self._stop = simulation, name, stop
        self._api = f"{url}/api/v1"
        self._mission_id = mission_id
        self._mission = f"/missions/{quote(mission_id)}"
        config = simulation.config
        self._device = (
            Device(simulation.world, simulation.tags, config.radio, config.seed)
            if config.tags == "node" and config.radio is not None
            else None
        )
        self._speed = speed if speed > 0.0 else 1.0
        base = simulation.starts[0]
        self._place = base.x, base.y
        self._at = BASE_TAG
        self._touched: tuple[str, float] | None = None  # the tag read before, and when
        self.reached: set[str] = set()  # victims they have been led to
        self._thread = threading.Thread(target=self._live, name="responder", daemon=True)

    def start(self) -> None:
        """Begin to walk as soon as robots have found somebody."""
        self._thread.start()

    def join(self) -> None:
        """Wait until they stand still after ``stop`` was set."""
        self._thread.join()

    def _live(self) -> None:
        while not self._stop.wait(_LOOK_EVERY_S / self._speed):
            victim = self._nearest_victim()
            if victim is not None and self._walk_to(victim):
                self.reached.add(victim)
                self._stop.wait(_WITH_VICTIM_S / self._speed)

    def _nearest_victim(self) -> str | None:
        """Return the nearest victim that a way leads to and where they have not been."""
        found = self._ask("GET", f"/where/{quote(self._at)}?{urlencode({'mission': self._mission_id})}")
        reachable = [v["victim_id"] for v in (found or {}).get("victims", []) if v["reachable"]]
        return next((victim for victim in reachable if victim not in self.reached), None)

    def _walk_to(self, victim: str) -> bool:
        """Walk until the victim is reached (True), or nothing leads on."""
        simulation, seed = self._simulation, self._simulation.config.seed + len(self.reached)
        walker = Walker(
            simulation.world,
            simulation.tags,
            simulation.victims,
            lambda tag: self._advice(tag, victim),
            self._place,
            seed,
            listen=None if self._device is None else self._listen,
        )
        due = time.monotonic()
        while not self._stop.is_set() and walker.advance():
            due = max(due + TICK_S / self._speed, time.monotonic() - 1.0)
            self._stop.wait(max(0.0, due - time.monotonic()))
        self._place = walker.x_m, walker.y_m
        return walker.arrived

    def _advice(self, tag: str, victim: str) -> Advice | None:
        """Say where they are, and return what the phone shows."""
        self._at = tag
        now = time.time()
        before, self._touched = self._touched, (tag, now)
        came = (
            {}
            if before is None or before[0] == tag
            else {"from_tag": before[0], "after_s": (now - before[1]) * self._speed}
        )
        said = came | {
            "kind": "at",
            "tag_id": tag,
            "made_by": self._name,
            "phone_unix_s": now,
            "sent_phone_unix_s": now,
        }
        self._ask("PUT", f"{self._mission}/reports/{uuid4()}", said)
        route = self._ask(
            "GET", f"{self._mission}/routes?{urlencode({'from': tag, 'to': f'victim:{victim}'})}"
        )
        if route is None:
            return None
        step = route["legs"][0] if route["legs"] else route["last"]
        if step is None:
            return None
        goal = step["points_m"][-1] if route["legs"] else (route["x_m"], route["y_m"])
        return Advice(step["bearing_deg"], step["text"], step.get("to_tag"), self._away(tag, goal))

    def _away(self, tag: str, place: Sequence[float]) -> tuple[float, float] | None:
        """Return where a place of the plan lies from a tag."""
        at = self._ask("GET", f"/where/{quote(tag)}?{urlencode({'mission': self._mission_id})}")
        return None if at is None else (place[0] - at["x_m"], place[1] - at["y_m"])

    def _listen(self, tag: str, x_m: float, y_m: float, steps: int) -> Fix | None:
        """Return where the server says that somebody is who hears what is to be heard there."""
        readings = [] if self._device is None else self._device.heard_at(x_m, y_m)
        heard = [{"node_id": node_id, "rssi_dbm": rssi_dbm} for node_id, rssi_dbm in readings]
        said = {"heard": heard, "last_tag": tag, "steps": steps}
        found = self._ask("POST", f"{self._mission}/where", said) if heard else None
        places = (found or {}).get("places", [])
        away = self._away(tag, (places[0]["x_m"], places[0]["y_m"])) if len(places) == 1 else None
        return None if away is None else Fix(away, places[0]["right_to_m"])

    def _ask(self, method: str, path: str, body: dict[str, Any] | None = None) -> dict[str, Any] | None:
        """Return the answer; None where there is none, or it is a refusal: a person looks again later."""
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"}
        request = urllib.request.Request(self._api + path, data, headers, method=method)
        try:
            with urllib.request.urlopen(request, timeout=_TIMEOUT_S) as reply:
                answer: dict[str, Any] = json.loads(reply.read())
                return answer
        except (OSError, ValueError):
            return None
