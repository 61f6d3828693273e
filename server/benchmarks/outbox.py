"""Reports over a link that fails in every way: whether each arrives, and no more than once.

A real browser runs the phone's own outbox against a real server. Requests are dropped on the way there or the
way back, answered with 503, sent twice; pages are reloaded, closed and opened twice at once in the middle.
"""

from __future__ import annotations

import base64
import io
import json
import random
import re
import time
import urllib.request
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from PIL import Image

from robots.client import RobotClient
from server.benchmarks.browser import OWN_MODULE, chromium, server_process

MISSION = "field"
# The outbox alone, begun where no page of the phone has begun it.
_OUTBOX = f"""{OWN_MODULE}("/static/phone/outbox.js").then(async (outbox) => {{
  globalThis.begun ??= document.getElementById("page") ? null : outbox.openOutbox();
  await globalThis.begun;
  return outbox;
}})"""
_ADD = f"""async ([kind, {{ picture, ...body }}]) => {{
  const bytes = Uint8Array.from(atob(picture ?? ""), (letter) => letter.charCodeAt(0));
  if (picture) body.picture = new Blob([bytes], {{ type: "image/jpeg" }});
  return {_OUTBOX}.then(({{ add }}) => add(kind, '{MISSION}', body)).then(({{ id }}) => id);
}}"""
_SEND = f"() => {_OUTBOX}.then(({{ sendNow }}) => void sendNow())"
_SENT = f"() => {_OUTBOX}.then(({{ sendNow }}) => sendNow())"
_LEFT = 'import("/static/phone/kept.js").then(({ keys }) => keys("outbox")).then((all) => all.length)'
_SETTLES_S = 60.0
_MAPPED = 5  # tags T0 to T4 are on the map, of T5 to T9 nobody knows
_REPORTS = re.compile(r"/(reports/|photos\?)")


@dataclass
class Tally:
    """What was made, id -> kind and text, what happened on the way, and what the server has in the end."""

    made: dict[str, tuple[str, str]] = field(default_factory=dict)
    faults: Counter[str] = field(default_factory=Counter)
    lost: list[str] = field(default_factory=list)
    doubled: list[str] = field(default_factory=list)
    victims: int = 0  # on the map


class Link:
    """The way to the server; ``share`` of the requests meet a fault."""

    def __init__(self, rng: random.Random, faults: Counter[str]) -> None:
        self.share = 0.0
        self._rng = rng
        self._faults = faults

    def __call__(self, route: Any) -> None:
        """Let a request through, or not (a handler of Playwright's ``route``)."""
        if self._rng.random() >= self.share:
            route.continue_()
            return
        fault = self._rng.choice(("lost on the way there", "lost on the way back", "busy", "sent twice"))
        self._faults[fault] += 1
        if fault == "lost on the way there":
            route.abort("connectionfailed")
        elif fault == "busy":
            route.fulfill(status=503, body="{}", headers={"Content-Type": "application/json"})
        elif fault == "lost on the way back":
            _passed_on(route)
            route.abort("connectionreset")
        else:
            _passed_on(route)
            _answer(route)


def _passed_on(route: Any) -> Any:
    """Send the request to the server; None where the server closed an idle connection just then."""
    photo = (
        _picture() if "/photos?" in route.request.url else None
    )  # Playwright does not see what a Blob holds
    try:
        return route.fetch(post_data=photo)
    except Exception as error:  # Playwright's own error is not imported where only the server runs
        if "ECONNRESET" not in str(error):
            raise
        return None


def _answer(route: Any) -> None:
    response = _passed_on(route)
    if response is None:
        route.abort("connectionreset")
    else:
        route.fulfill(response=response)


def run(context: Any, home: str, sequences: int, seed: int, page: str = "/phone") -> Tally:
    """Play sequences in a browser's context (Playwright) against the server at ``home``.

    The context must block service workers, whose requests Playwright does not see. ``page``: where the outbox
    runs; any of the server's, the phone's own takes longer to load.

    Raises:
        TimeoutError: reports still wait a minute after the link has become sound.
    """
    rng = random.Random(seed)
    tally = Tally()
    link = Link(
        random.Random(seed + 1), tally.faults
    )  # how many requests there are must not change what is done
    _drive_past_tags(home)
    context.route(_REPORTS, link)
    for sequence in range(sequences):
        link.share = rng.choice((0.2, 0.5, 0.8, 1.0))
        _play(context, home + page, rng, tally, sequence)
    link.share = 0.0
    _settle(context, home + page)
    _count(home, tally)
    return tally


def _play(context: Any, address: str, rng: random.Random, tally: Tally, sequence: int) -> None:
    page = _page(context, address)
    for step in range(rng.randint(3, 8)):
        action = rng.choices(("report", "send", "reload", "another", "close"), (10, 4, 3, 1, 1))[0]
        if action != "report":
            tally.faults[action] += 1
        if action == "report":
            text = f"{sequence}.{step}"
            kind, body = _report(rng, text)
            tally.made[page.evaluate(_ADD, [kind, body])] = kind, text
        elif action == "send":
            page.evaluate(_SEND)
        elif action == "reload":
            page.reload()
        elif action == "another":  # both send what waits
            context.new_page().goto(address)
        else:
            page.close()
            page = _page(context, address)
    for extra in context.pages[1:]:
        extra.close()


def _report(rng: random.Random, text: str) -> tuple[str, dict[str, Any]]:
    (kind,) = rng.choices(("note", "victim", "photo", "mayday", "at", "heard"), (3, 3, 2, 1, 1, 1))
    if kind == "heard":
        return kind, {"since_unix_s": float(rng.randint(1, 9))}
    body: dict[str, Any] = {"tag_id": f"T{rng.randint(0, 2 * _MAPPED - 1)}"}
    if kind != "at":
        body["text"] = text
    if kind == "note":
        body["note"] = rng.choice(("hazard", "note", "searched", "exit"))
    if kind == "victim":
        body |= {"live": rng.randint(0, 3), "dead": rng.randint(0, 1), "start": {"walks": True}}
    if kind == "photo":
        body["picture"] = base64.b64encode(_picture()).decode()
    return kind, body


def _picture() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (32, 24), (200, 60, 20)).save(file, "JPEG")
    return file.getvalue()


def _drive_past_tags(home: str) -> None:
    """Open the mission, and have a robot pass tags two metres apart."""
    robot = RobotClient(home, MISSION, "r1", patience_s=_SETTLES_S)
    robot.create_mission("Field", tag_key="")
    robot.register(start_pose={"x_m": 0.0, "y_m": 0.0, "yaw_rad": 0.0, "sd_m": 0.05, "sd_rad": 0.01})
    step = {"kind": "displacement", "dy_m": 0.0, "dtheta_rad": 0.0}
    robot.post(
        [
            {
                "seq": k,
                "stamp_s": float(k),
                "odometry": step | {"dx_m": 1.0 if k else 0.0},
                "tag_sightings": [] if k % 2 else [{"tag_id": f"T{k // 2}"}],
            }
            for k in range(2 * _MAPPED)
        ]
    )
    robot.close()
    until = time.monotonic() + _SETTLES_S
    while len(_call(home, "GET", f"/missions/{MISSION}/tags")["tags"]) < _MAPPED:
        if time.monotonic() > until:
            raise TimeoutError("the tags do not come onto the map")
        time.sleep(0.1)


def _page(context: Any, address: str) -> Any:
    if not context.pages:
        context.new_page().goto(address)
    return context.pages[0]


def _settle(context: Any, address: str) -> None:
    page = _page(context, address)
    until = time.monotonic() + _SETTLES_S
    while page.evaluate(_LEFT):
        if time.monotonic() > until:
            raise TimeoutError("reports still wait though the link is sound")
        page.evaluate(_SENT)
        page.wait_for_timeout(100)


def _count(home: str, tally: Tally) -> None:
    """Compare with what the server has: the reports, and what stands on the map because of them."""
    mission = f"/missions/{MISSION}"
    photos = _call(home, "GET", f"{mission}/photos")["photos"]
    reports = _call(home, "GET", f"{mission}/reports?limit=10000")["reports"]
    there = Counter([report["report_id"] for report in reports] + [photo["photo_id"] for photo in photos])
    notes = _call(home, "GET", f"{mission}/annotations")["annotations"]
    victims = _call(home, "GET", f"{mission}/victims")["victims"]
    said = [note["text"] for note in notes] + [victim["note"] for victim in victims]
    shown = Counter(text.rsplit(" ", 1)[-1] for text in said + [photo["text"] for photo in photos])
    for name, (kind, text) in tally.made.items():
        is_shown = kind in ("note", "victim", "photo")
        if (kind != "at" and not there[name]) or (
            is_shown and not shown[text]
        ):  # of places the last one counts
            tally.lost.append(name)
        if there[name] > 1 or shown[text] > 1:
            tally.doubled.append(name)
    tally.doubled += [name for name in there if name not in tally.made]
    tally.victims = len(victims)


def _call(home: str, method: str, path: str, body: object = None) -> Any:
    request = urllib.request.Request(
        f"{home}/api/v1{path}",
        data=None if body is None else json.dumps(body).encode(),
        method=method,
        headers={"Content-Type": "application/json"},
    )
    with urllib.request.urlopen(request, timeout=30) as response:
        return json.loads(response.read())


def measure(sequences: int, seed: int) -> dict[str, Any]:
    """Return how many reports were made, lost and doubled, and what they met on the way.

    Raises:
        CannotMeasureError: there is no browser here.
    """
    with server_process() as home, chromium() as browser:
        context = browser.new_context(service_workers="block")
        tally = run(context, home, sequences, seed, page="/static/logo.svg")
        context.close()
    found = {"sequences": sequences, "reports made": len(tally.made)}
    found |= Counter(kind for kind, _ in tally.made.values()) | {"victims on the map": tally.victims}
    return found | dict(tally.faults) | {"lost": len(tally.lost), "doubled": len(tally.doubled)}
