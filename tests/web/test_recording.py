"""A film of a long mission: bounded, as long as the mission, and true at its end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
import pytest
import zstandard

from web.viser.map_layer import Grid
from web.viser.recording import record

HOURS_S = 4 * 3600


def steps() -> Iterator[tuple[float, dict[str, Any]]]:
    """A robot that creeps along, told of four times a minute, and its trail."""
    for t in range(0, HOURS_S + 1, 15):
        x_m = t / 1000
        robot = {"x_m": x_m, "y_m": 0.0, "yaw_rad": 0.0, "covariance": [0.01, 0.0, 0.01], "link": "live"}
        trail = {"robot_id": "r1", "points_m": [[0.0, 0.0], [x_m, 0.0]]}
        yield float(t), {"robot/r1": robot, "trail/r1": trail, "map": {"version": t}}


def test_a_film_of_hours_is_bounded_and_ends_with_the_mission() -> None:
    grid = Grid(np.full((8, 8), 100, np.int8), (0.0, 0.0), 0.5)
    packed = record(steps(), lambda _shown: grid, HOURS_S)
    content = zstandard.ZstdDecompressor().decompressobj().decompress(packed[8:])
    film = msgspec.msgpack.decode(content[8 : 8 + int.from_bytes(content[:8], "little")])
    assert film["durationSeconds"] == pytest.approx(HOURS_S, abs=1)
    named: dict[str, list[dict[str, Any]]] = {}
    for _, message in film["messages"]:
        named.setdefault(message.get("name", ""), []).append(message)
    places = [m["position"][0] for m in named["/robots/1"] if m["type"] == "SetPositionMessage"]
    assert 300 < len(places) <= 602
    assert places[-1] == pytest.approx(HOURS_S / 1000)
    for slow in ("/trails/1", "/map/walls"):
        assert 30 < sum("props" in message for message in named[slow]) <= 62
