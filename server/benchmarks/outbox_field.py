"""A mission with people, a robot that passed tags, and the chips in these tags, for random reports."""

from __future__ import annotations

import asyncio
import base64
import json
import random
import time
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from db.people_records import Role
from db.store import Store
from robots.client import RobotClient
from robots.tags.chip import CHIPS, read_chip
from robots.tags.content import encode_memory
from robots.tags.marks import victim_mark
from robots.tags.memory import TagMemory
from robots.tags.reader import SimulatedTag, read_tag, write_tag
from robots.tags.record import seal
from robots.tags.sealed import unsealed_notes
from server.benchmarks.outbox_phone import MISSION
from server.mission.chip_notes import chip_note_id
from server.people.accounts import Accounts
from server.settings import Settings

MAPPED = 5  # tags T0 to T4 are on the map, of T5 to T9 nobody knows
PEOPLE = ("Ann Østergård-Lindqvist", "ben")  # the first has no room for her name in a tag
_KEY = "5eed"
_PASSWORD = "a long password"
_SETTLES_S = 60.0


def links(data: Path) -> list[str]:
    """Make links for a commander and the people, in the database of a server that does not run yet."""
    with ThreadPoolExecutor() as aside:  # Playwright has an event loop in this thread
        return aside.submit(asyncio.run, _links(data)).result()


async def _links(data: Path) -> list[str]:
    store = await Store.open(Settings.model_validate({"data_dir": data}).database_target)
    try:
        accounts = Accounts(store)
        people: list[Role] = ["responder"] * len(PEOPLE)
        roles: list[Role] = ["commander", *people]
        return [(await accounts.make_link(role, "bench"))[0] for role in roles]
    finally:
        await store.close()


class FieldOfTags:
    """The mission, as its commander sees it, and the chips of its tags."""

    def __init__(self, home: str, secrets: list[str], rng: random.Random) -> None:
        self.home = home
        self._rng = rng
        self._cookie = ""
        self._cookie, *self.cookies = (
            self._join(secret, name) for secret, name in zip(secrets, ("Chief", *PEOPLE), strict=True)
        )
        self._robot = RobotClient(
            home, MISSION, "r1", patience_s=_SETTLES_S, headers={"Cookie": self._cookie}
        )
        self._seq = 0
        self._chips: dict[str, SimulatedTag] = {}
        self.copies: set[str] = set()  # ids that notes in chips have on the map
        self._drive_past_tags()

    def close(self) -> None:
        """Let go of the robot's line."""
        self._robot.close()

    def link(self, tag_id: str) -> str:
        """Return the link that a tag bears."""
        return f"{self.home}/t/{tag_id}"

    def new_chips(self) -> None:
        """Let all tags have other chips, some with what a robot sealed in them."""
        self._chips = {}
        for k in range(MAPPED):
            tag_id, chip = f"T{k}", self._rng.choice(list(CHIPS.values())[2:])
            tag = self._chips[tag_id] = SimulatedTag.formatted(chip, self.link(tag_id))
            for revision in range(self._rng.randint(0, 2)):
                memory = TagMemory(TagMemory.empty().cells, (), (victim_mark("v", 0.5, 60.0, 1.0, -2.0),))
                content = encode_memory(memory.fit(read_tag(tag).room_bytes))
                write_tag(tag, seal(content, revision, tag_id, bytes.fromhex(_KEY)))

    def payload(self, tag_id: str) -> bytes:
        """Return our record on a tag's chip, as a phone reads it."""
        memory, (_, layout) = self._chips[tag_id].read(), read_chip(self._chips[tag_id].read())
        return memory[layout.start : layout.start + layout.size]

    def write(self, tag_id: str, payload: bytes) -> None:
        """Let a chip hold what a phone has written, or a part of it."""
        tag = self._chips[tag_id]
        memory, (_, layout) = bytearray(tag.read()), read_chip(tag.read())
        memory[layout.start : layout.start + layout.size] = payload
        self._chips[tag_id] = SimulatedTag(tag.chip, bytes(memory))
        told = b"".join(read_tag(self._chips[tag_id]).records)
        self.copies |= {
            chip_note_id(tag_id, note.author, note.text)
            for note in unsealed_notes(told, tag_id, bytes.fromhex(_KEY))
        }

    def bring_home(self) -> None:
        """Let the robot read the chip of the tag that it stands at."""
        tag_id = f"T{MAPPED - 1}"
        records = b"".join(read_tag(self._chips[tag_id]).records)
        self._post({"tag_id": tag_id, "memory": base64.b64encode(records).decode()}, 0.0)

    def get(self, path: str) -> Any:
        """Return what the mission has under a path, as its commander gets it."""
        return self._call("GET", f"/missions/{MISSION}/{path}")[0]

    def _drive_past_tags(self) -> None:
        """Open the mission, and have a robot pass tags two metres apart."""
        self._robot.create_mission("Field", tag_key=_KEY)
        start = {"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01}
        self._robot.register(start_pose=start)
        for k in range(2 * MAPPED - 1):
            self._post(None if k % 2 else {"tag_id": f"T{k // 2}"}, 1.0 if k else 0.0)
        until = time.monotonic() + _SETTLES_S
        while len(self.get("tags")["tags"]) < MAPPED:
            if time.monotonic() > until:
                raise TimeoutError("the tags do not come onto the map")
            time.sleep(0.1)

    def _post(self, sighting: dict[str, str] | None, dx_m: float) -> None:
        step = {"kind": "displacement", "dx_m": dx_m, "dy_m": 0.0, "dtheta_rad": 0.0}
        seen = [] if sighting is None else [sighting]
        said = {"seq": self._seq, "stamp_s": float(self._seq), "odometry": step, "tag_sightings": seen}
        self._seq += 1
        self._robot.post([said])

    def _join(self, secret: str, name: str) -> str:
        words = {"secret": secret, "name": name, "password": _PASSWORD}
        cookie: str = self._call("POST", "/join", words)[1]["Set-Cookie"].partition(";")[0]
        return cookie

    def _call(self, method: str, path: str, body: object = None) -> Any:
        request = urllib.request.Request(
            f"{self.home}/api/v1{path}",
            data=None if body is None else json.dumps(body).encode(),
            method=method,
            headers={"Content-Type": "application/json", "Cookie": self._cookie},
        )
        with urllib.request.urlopen(request, timeout=60) as response:
            return json.loads(response.read()), response.headers
