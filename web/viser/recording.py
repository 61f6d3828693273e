"""A mission's scene over time as one file of viser's player (.viser)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from web.viser.map_layer import Grid
from web.viser.scene import MissionScene

_POSES_S = 1.0
_POSE_DRAWINGS = 600  # of them in a film, however long
_SLOW_S = 10.0  # walls and trails: large, and in a film nobody sees them come
_SLOW_DRAWINGS = 60  # of them in a film, however long: they are most of its work and of its bytes
_STOOD_S = 20.0  # as long without a change, and the mission stood: the film goes on at once

Value = dict[str, Any]


def record(
    steps: Iterable[tuple[float, dict[str, Value]]],
    grid_of: Callable[[Value], Grid | None],
    length_s: float,
) -> bytes:
    """Return the recording of states with their times, oldest first; ``length_s``: how long they are in all.

    ``grid_of`` gives the map of a state's value of ``map``, None where its picture was not kept.
    """
    poses_s = max(_POSES_S, length_s / _POSE_DRAWINGS)
    slow_s = max(_SLOW_S, length_s / _SLOW_DRAWINGS)
    scene = MissionScene(slow_draw_s=slow_s)
    try:
        film = scene.serializer()
        before_s: float | None = None
        film_s = drawn_s = 0.0
        version = None
        state: dict[str, Value] = {}
        for unix_s, state in steps:
            film_s += 0.0 if before_s is None else min(max(0.0, unix_s - before_s), _STOOD_S)
            is_due = before_s is None or film_s - drawn_s >= poses_s
            before_s = unix_s
            if not is_due:
                continue
            film.insert_sleep(film_s - drawn_s)
            drawn_s = film_s
            scene.replace(state)
            if "map" in state and state["map"]["version"] != version and scene.is_slow_due(film_s):
                version = state["map"]["version"]
                _put_map(scene, grid_of(state["map"]))
            scene.draw(scene.take(film_s))
        if "map" in state:
            _put_map(scene, grid_of(state["map"]))
        film.insert_sleep(film_s - drawn_s)
        scene.replace(state)
        scene.draw(scene.take(film_s + slow_s))  # what was not due yet
        scene.look_from_above()
        return bytes(film.serialize())
    finally:
        scene.stop()


def _put_map(scene: MissionScene, grid: Grid | None) -> None:
    if grid is not None:
        scene.update_map(grid.cells, grid.origin_m, grid.resolution_m)
