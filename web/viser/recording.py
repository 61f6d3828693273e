"""A mission's scene over time as one file of viser's player (.viser)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from web.viser.map_layer import Grid
from web.viser.scene import MissionScene

_POSES_S = 1.0
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
    slow_s = max(_SLOW_S, length_s / _SLOW_DRAWINGS)
    scene = MissionScene(slow_draw_s=slow_s)
    try:
        film = scene.serializer()
        last_s: float | None = None
        film_s = 0.0
        version = None
        state: dict[str, Value] = {}
        for unix_s, state in steps:
            if last_s is not None:
                if unix_s - last_s < _POSES_S:
                    continue
                passed_s = min(unix_s - last_s, _STOOD_S)
                film_s += passed_s
                film.insert_sleep(passed_s)
            last_s = unix_s
            scene.replace(state)
            if "map" in state and state["map"]["version"] != version and scene.is_slow_due(film_s):
                version = state["map"]["version"]
                _put_map(scene, grid_of(state["map"]))
            scene.draw(scene.take(film_s))
        if "map" in state:
            _put_map(scene, grid_of(state["map"]))
        scene.replace(state)
        scene.draw(scene.take(film_s + slow_s))  # what was not due yet
        scene.look_from_above()
        return bytes(film.serialize())
    finally:
        scene.stop()


def _put_map(scene: MissionScene, grid: Grid | None) -> None:
    if grid is not None:
        scene.update_map(grid.cells, grid.origin_m, grid.resolution_m)
