"""What the report tells of victims, robots, alerts, notes, tags and events, a part each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, sqrt
from typing import Any

from db.records import EventRecord
from server.history.changes import Value
from server.markings.victims import victim_markings, victim_words
from server.report.drawing import number
from server.report.html import Html, clock, duration, facts, table, tag
from server.report.markings import sprayed
from server.report.photos import Shot, figures
from server.report.story import Said, Story

_SAID_WORDS: Mapping[str, str] = {
    "status": "status", "team": "team", "note": "note", "live": "alive there", "dead": "dead there",
    "triage": "triage", "place_m": "place", "merged_into": "is the same as",
}  # fmt: skip


def wait_s(alert: Value) -> float | None:
    """Return how long it took until somebody took note of an alert; None where nobody did."""
    noted = alert["acknowledged_unix_s"]
    return None if noted is None else max(0.0, noted - alert["raised_unix_s"])


def victim_part(victim: Value, n: int, story: Story, shots: Sequence[Shot]) -> Html:
    """Return one victim: markings, facts, photos, and who said what when."""
    name = victim["victim_id"]
    tags = story.of_kind("tag")
    near = min(tags, key=lambda each: _apart_m(each, victim), default=None)
    place = f"{victim['x_m']:.1f} / {victim['y_m']:.1f} m"
    if near is not None:
        place += f", {_apart_m(near, victim):.1f} m from tag {near['tag_id']}"
    told = [(clock(each.unix_s), each.by, _words(each)) for each in story.said.get(name, [])]
    first = (clock(story.first_seen_s[name]), ", ".join(victim["robots"]), "seen first")
    return tag(
        "article",
        tag("h3", f"{n}  {name}: {victim['status']}"),
        sprayed(victim_markings(victim)),
        facts((
            ("Place", place),
            ("Certainty", f"{victim['confidence']:.0%}, seen {victim['sightings']} times"),
            ("START triage", victim["triage"]),
            ("Alive there", victim["live"]),
            ("Dead there", victim["dead"]),
            ("Marking", victim_words(victim)),
            ("Team", victim["team"]),
            ("Note", victim["note"]),
        )),
        figures(shots),
        table(("Time", "Who", "What"), [first, *told]),
        class_="victim",
    )  # fmt: skip


def _apart_m(one: Value, other: Value) -> float:
    return hypot(one["x_m"] - other["x_m"], one["y_m"] - other["y_m"])


def _within_m(thing: Value) -> float:
    """Return two standard deviations along the axis on which a place is known worse."""
    return 2.0 * sqrt(max(thing["covariance"][0], thing["covariance"][2], 0.0))


def _words(said: Said) -> str:
    def value(name: str, item: Any) -> str:
        if item is None or item == "":
            return "taken back"
        return f"{item[0]:.1f} / {item[1]:.1f} m" if name == "place_m" else str(item)

    return ", ".join(f"{_SAID_WORDS[name]}: {value(name, item)}" for name, item in said.words.items())


def robots_part(story: Story) -> Html:
    """Return the robots at the end."""
    rows = [
        (
            name, robot["activity"], f"{robot['distance_m']:.0f} m", f"{robot['explored_m2']:.0f} m²",
            "" if robot["battery"] is None else f"{robot['battery']:.0%}", robot["tags_left"],
            f"{robot['x_m']:.1f} / {robot['y_m']:.1f} m, ± {_within_m(robot):.1f} m",
            clock(robot["heard_unix_s"]), robot["methods"].get("explore", ""),
        )
        for name, robot in sorted(story.robots.items())
    ]  # fmt: skip
    heads = (
        "Robot",
        "State",
        "Driven",
        "Explored",
        "Battery",
        "Tags left",
        "Last place (2σ)",
        "Last heard",
        "Explores by",
    )
    return _section("Robots", heads, rows, "No robot was heard.")


def alerts_part(story: Story) -> Html:
    """Return every alert, and how long it took to be noted."""
    rows = []
    for (_, raised), alert in sorted(story.alerts.items(), key=lambda item: item[0][1]):
        wait = wait_s(alert)
        noted = "nobody" if wait is None else f"{alert['acknowledged_by']}, after {duration(wait)}"
        rows.append((clock(raised), alert["severity"], alert["text"], noted, clock(alert["over_unix_s"])))
    return _section(
        "Alerts", ("Raised", "How bad", "What", "Taken note of by", "Over"), rows, "There was no alert."
    )


def notes_part(story: Story) -> Html:
    """Return what people wrote on the map."""
    rows = []
    for name, note in sorted(story.notes.items(), key=lambda item: item[1]["created_unix_s"]):
        where = "" if note["x_m"] is None else f"{note['x_m']:.1f} / {note['y_m']:.1f} m"
        if note["tag_id"]:
            where = f"tag {note['tag_id']}"
        elif note["area_m"]:
            where = f"area of {len(note['area_m'])} corners"
        gone = "" if f"annotation/{name}" in story.state else "removed"
        rows.append((clock(note["changed_unix_s"]), note["by"], note["kind"], note["text"], where, gone))
    return _section(
        "Notes and hazards",
        ("Time", "Who", "Kind", "What", "Where", ""),
        rows,
        "Nobody wrote anything on the map.",
    )


def tags_part(story: Story) -> Html:
    """Return the tags by id."""
    rows = [
        (
            each["tag_id"], number(each["x_m"]), number(each["y_m"]),
            number(_within_m(each)), each["sightings"],
            ", ".join(each["robots"]), each["notice"] or each["state"],
        )
        for each in story.of_kind("tag")
    ]  # fmt: skip
    return _section(
        "Tags", ("Tag", "x (m)", "y (m)", "± (2σ, m)", "Seen", "By", "State"), rows, "No tag was seen."
    )


def timeline_part(events: Sequence[EventRecord]) -> Html:
    """Return everything that happened, a line each."""
    rows = [
        (
            tag("time", clock(event.unix_s), data_unix_s=f"{event.unix_s:.1f}"),
            "" if event.severity == "info" else event.severity,
            event.text,
        )
        for event in events
    ]  # fmt: skip
    return _section("Timeline", ("Time", "", "What happened"), rows, "Nothing happened.", class_="timeline")


def _section(
    title: str, heads: Sequence[str], rows: Sequence[Sequence[object]], empty: str, **more: str
) -> Html:
    content = table(heads, rows, **more) if rows else tag("p", empty)
    return tag("section", tag("h2", title), content)
