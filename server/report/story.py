"""What happened in a mission, from its past: the end, what was said when, and a film in few frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

from server.history.changes import Value
from server.history.past import steps

T = TypeVar("T")

_FRAMES = 600
_PICTURES = 48
_STOOD_S = 20.0  # as long without a change, and the mission stood: such stretches are left out
_SAID = ("status", "team", "note", "live", "dead", "triage", "place_m", "merged_into")


@dataclass(frozen=True, slots=True)
class Said:
    """What differs after somebody spoke of a victim."""

    unix_s: float
    by: str
    words: Mapping[str, Any]


@dataclass(slots=True)
class Frame:
    """A moment of the film: poses (x, y, heading) by robot, and the version of the map."""

    unix_s: float
    poses: dict[str, tuple[float, float, float]]
    map_version: int | None


@dataclass(slots=True)
class Story:
    """``state``: the last one; ``alerts`` by id and time raised, as they ended; ``maps`` by version."""

    begins_unix_s: float | None = None
    ends_unix_s: float | None = None
    recorded_s: float = 0.0
    state: dict[str, Value] = field(default_factory=dict)
    first_seen_s: dict[str, float] = field(default_factory=dict)
    said: dict[str, list[Said]] = field(default_factory=dict)
    alerts: dict[tuple[str, float], Value] = field(default_factory=dict)
    notes: dict[str, Value] = field(default_factory=dict)
    robots: dict[str, Value] = field(default_factory=dict)
    frames: list[Frame] = field(default_factory=list)
    maps: dict[int, Value] = field(default_factory=dict)

    def of_kind(self, kind: str) -> list[Value]:
        """Return the last values of a kind by id."""
        keys = sorted(key for key in self.state if key.startswith(f"{kind}/"))
        return [self.state[key] for key in keys]


def tell(chunks: Iterable[bytes]) -> Story:
    """Return the story of a mission's chunks, oldest first."""
    story = Story()
    before: dict[str, Value] = {}
    for chunk in chunks:
        for unix_s, state in steps(chunk):
            if story.begins_unix_s is None:
                story.begins_unix_s = unix_s
            _note(story, unix_s, before, state)
            _settle(story, unix_s, before, state)
            _film(story, unix_s, state)
            story.recorded_s += min(_STOOD_S, unix_s - (story.ends_unix_s or unix_s))
            story.ends_unix_s = unix_s
            before = dict(state)
    story.state = before
    story.frames = _thinned(story.frames, _FRAMES)
    return story


def pictures_of(story: Story) -> list[int]:
    """Return the versions of the map that are worth their room: the last one, and some on the way."""
    versions = sorted(story.maps)
    return _thinned(versions, _PICTURES)


def _note(story: Story, unix_s: float, before: Mapping[str, Value], state: Mapping[str, Value]) -> None:
    for key, value in state.items():
        old = before.get(key)
        if old is value:
            continue
        kind, _, name = key.partition("/")
        if kind == "victim":
            story.first_seen_s.setdefault(name, unix_s)
            _hear(story, unix_s, name, old or {}, value)
        elif kind == "alert":
            story.alerts[name, value["raised_unix_s"]] = value
        elif kind == "annotation":
            story.notes[name] = value
        elif kind == "robot":
            story.robots[name] = value
        elif kind == "map":
            story.maps[value["version"]] = value


def _settle(story: Story, unix_s: float, before: Mapping[str, Value], state: Mapping[str, Value]) -> None:
    """Alerts that are over and taken note of are shown no more: then both happened by now."""
    for key in before.keys() - state.keys():
        if key.startswith("alert/"):
            alert = before[key]
            noted = {"acknowledged_unix_s": unix_s, "acknowledged_by": "somebody"}
            done = {} if alert["acknowledged_unix_s"] is not None else noted
            over = alert["over_unix_s"] or unix_s
            story.alerts[alert["alert_id"], alert["raised_unix_s"]] = {**alert, **done, "over_unix_s": over}


def _hear(story: Story, unix_s: float, name: str, old: Value, new: Value) -> None:
    words = {item: new.get(item) for item in _SAID if new.get(item) != old.get(item)}
    if words and new.get("by"):
        story.said.setdefault(name, []).append(Said(new.get("changed_unix_s") or unix_s, new["by"], words))


def _film(story: Story, unix_s: float, state: Mapping[str, Value]) -> None:
    if story.frames and unix_s - story.frames[-1].unix_s < 1.0:
        return
    poses = {
        value["robot_id"]: (round(value["x_m"], 2), round(value["y_m"], 2), round(value["yaw_rad"], 2))
        for key, value in state.items()
        if key.startswith("robot/") and value["located"]
    }
    shown = state.get("map")
    if poses or story.frames:
        story.frames.append(Frame(unix_s, poses, None if shown is None else shown["version"]))


def _thinned(items: list[T], most: int) -> list[T]:
    """Return at most so many, evenly spread, the last among them."""
    if len(items) <= most:
        return items
    step = (len(items) - 1) / (most - 1)
    return [items[round(k * step)] for k in range(most)]
