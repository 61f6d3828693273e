"""The report as one HTML file: no outside resource, nothing but text from outside, good to print on A4."""

from __future__ import annotations

import base64
import json
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from statistics import median
from typing import Any

from db.records import EventRecord, MissionRecord
from server import VERSION
from server.history.changes import Value
from server.report.drawing import data_address, plan, robot_color
from server.report.html import Html, day_and_time, duration, facts, join, tag, text
from server.report.parts import (
    alerts_part,
    notes_part,
    robots_part,
    tags_part,
    timeline_part,
    victim_part,
    wait_s,
)
from server.report.photos import Album, photos_part
from server.report.sectors import sectors_part
from server.report.story import Story

_PLAN_WORDS = (
    "Numbers in boxes are victims. The building is drawn as the robots measured it; North is to the right."
)
_FILES = Path(__file__).parents[2] / "web" / "static" / "report"


def report_page(
    mission: MissionRecord,
    story: Story,
    pictures: Mapping[int, bytes],
    events: Sequence[EventRecord],
    album: Album,
) -> str:
    """Return the report of a mission; ``pictures``: PNG by version of the map, the last one among them."""
    script = (_FILES / "player.js").read_text()
    policy = content_security_policy()
    shown = story.state.get("map")
    victims = sorted(
        (v for v in story.of_kind("victim") if not v["merged_into"]),
        key=lambda v: story.first_seen_s[v["victim_id"]],
    )
    numbers = {victim["victim_id"]: n for n, victim in enumerate(victims, 1)}
    drawn = plan(shown, None if shown is None else pictures.get(shown["version"]), story.state, numbers)
    told = [
        victim_part(victim, numbers[name], story, album.of_victim(name))
        for victim in victims
        for name in [victim["victim_id"]]
    ]
    told = told or [tag("p", "No victim was seen.")]
    body = join((
        _head(mission, story, victims, events),
        tag("section", tag("h2", "Plan"), drawn, tag("p", _PLAN_WORDS, class_="small"), class_="page"),
        _film(story, pictures),
        tag("section", tag("h2", "Victims"), *told),
        sectors_part(story),
        robots_part(story),
        alerts_part(story),
        notes_part(story),
        photos_part(album, numbers, {name: note["text"] for name, note in story.notes.items()}),
        tags_part(story),
        timeline_part(events),
        tag("script", Html(script)),
    ))  # fmt: skip
    head = join((
        Html('<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'),
        Html(f'<meta http-equiv="Content-Security-Policy" content="{text(policy)}">'),
        tag("title", f"Report of {mission.name}"),
        tag("style", Html((_FILES / "report.css").read_text())),
    ))  # fmt: skip
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>{body}</body></html>\n'


def content_security_policy() -> str:
    """Return the policy of the page: its own script and pictures within it, nothing else at all."""
    digest = base64.b64encode(sha256((_FILES / "player.js").read_bytes()).digest()).decode()
    return f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'"


def _head(
    mission: MissionRecord, story: Story, victims: Sequence[Value], events: Sequence[EventRecord]
) -> Html:
    waits = [wait for alert in story.alerts.values() if (wait := wait_s(alert)) is not None]
    shown = story.state.get("map")
    made = (
        f"Report of mission {mission.mission_id}, made {day_and_time(time.time())} by Waymark {VERSION}."
        " All times are those of that place."
    )
    statuses = Counter(victim["status"] for victim in victims)
    alarms = sum(alert["severity"] == "alarm" for alert in story.alerts.values())
    return tag(
        "header",
        tag("h1", mission.name),
        tag("p", made, class_="small"),
        facts((
            ("State", mission.state),
            ("Opened", day_and_time(mission.created_unix_s)),
            ("Last change", None if story.ends_unix_s is None else day_and_time(story.ends_unix_s)),
            ("Recorded", duration(story.recorded_s)),
            ("Robots", len(story.robots)),
            ("Explored", None if shown is None else f"{shown['explored_m2']:.0f} m²"),
            ("Victims", ", ".join(f"{n} {status}" for status, n in statuses.items()) or "none seen"),
            ("Alerts", f"{len(story.alerts)}, {alarms} of them alarms"),
            ("Until somebody took note of an alert", _waits(waits)),
            ("Tags", len(story.of_kind("tag"))),
            ("Events", len(events)),
        )),
    )  # fmt: skip


def _waits(waits: Sequence[float]) -> str | None:
    if not waits:
        return None
    return f"{duration(median(waits))} (middle of {len(waits)}), {duration(max(waits))} at most"


def _film(story: Story, pictures: Mapping[int, bytes]) -> Html:
    """Return the player's data; a script makes the player of it, and paper shows nothing."""
    if not story.frames:
        return Html("")
    robots = sorted({name for frame in story.frames for name in frame.poses})
    kept = sorted(pictures)
    film = {
        "times": [round(frame.unix_s, 1) for frame in story.frames],
        "robots": [
            {
                "name": name,
                "color": robot_color(name),
                "poses": [frame.poses.get(name) for frame in story.frames],
            }
            for name in robots
        ],
        "maps": [_picture(kept, frame.map_version) for frame in story.frames],
        "pictures": {v: {**_place(story.maps[v]), "png": data_address(pictures[v])} for v in kept},
        "tags": [[each["x_m"], each["y_m"]] for each in story.of_kind("tag")],
        "victims": [
            {"name": v["victim_id"], "at": [v["x_m"], v["y_m"]], "since": story.first_seen_s[v["victim_id"]]}
            for v in story.of_kind("victim")
        ],
    }  # fmt: skip
    data = json.dumps(film, separators=(",", ":")).replace("<", "\\u003c")
    return tag(
        "section", tag("h2", "Film"), tag("div", id="player"),
        tag("script", Html(data), type="application/json", id="film"), class_="screen",
    )  # fmt: skip


def _picture(kept: Sequence[int], version: int | None) -> int | None:
    """Return the newest picture that was there when a version was shown."""
    return None if version is None else max((each for each in kept if each <= version), default=None)


def _place(shown: Value) -> dict[str, Any]:
    return {name: shown[name] for name in ("origin_m", "width", "height", "resolution_m")}
