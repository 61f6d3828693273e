"""Bluetooth signals with positions (Danis 2022): a beacon is carried past twelve receivers in a laboratory.

A folder with ``cnf/*.dev`` (a line ``Dongles:`` with the receivers' places, in metres) and ``trk/*.mbd``, one
reading a line: time, receiver, beacon, signal in dBm, place of the beacon in metres, and its rotation.
"""

from __future__ import annotations

import json
from math import dist, isfinite
from pathlib import Path

from robots.datasets.recording import RecordingError
from robots.estimation.radio.fit import Collector, Signals

_MOST_BYTES = 200_000_000
_FIELDS = 7  # that are needed; the rotation is not

Place = tuple[float, float, float]


def load_signals(path: Path) -> Signals:
    """Read all tracks of the folder, or one ``.mbd`` file of it.

    Raises:
        RecordingError: a file is missing or damaged; the message names file and line.
    """
    folder = path.parent.parent if path.is_file() else path
    tracks = [path] if path.is_file() else sorted(folder.glob("trk/*.mbd"))
    devices = sorted(folder.glob("cnf/*.dev"))
    if not tracks or not devices:
        raise RecordingError(f"{path} is no such recording: it needs trk/*.mbd and cnf/*.dev")
    receivers = _receivers(devices[0])
    collector = Collector()
    for track in tracks:
        for number, line in enumerate(_text(track).splitlines(), 1):
            if line.strip():
                receiver, rssi, place = _reading(track, number, line, receivers)
                collector.add(receiver, place[0], place[1], dist(receivers[receiver], place), rssi)
    return collector.signals()


def _reading(track: Path, number: int, line: str, receivers: dict[str, Place]) -> tuple[str, float, Place]:
    fields = line.split(",")
    try:
        receiver, values = fields[1].strip(), [float(each) for each in fields[3:_FIELDS]]
    except (IndexError, ValueError):
        values, receiver = [], ""
    if len(values) != _FIELDS - 3 or not all(map(isfinite, values)):
        raise RecordingError(f"{track}, line {number} is no reading: time, receiver, beacon, dBm, x, y, z")
    if receiver not in receivers:
        raise RecordingError(f"{track}, line {number}: nobody says where receiver {receiver[:40]!r} is")
    rssi, x, y, z = values
    return receiver, rssi, (x, y, z)


def _receivers(path: Path) -> dict[str, Place]:
    for line in _text(path).splitlines():
        if not line.startswith("Dongles:"):
            continue
        try:
            devices = json.loads(line.removeprefix("Dongles:"))
            places = {name: tuple(float(each) for each in device[0]) for name, device in devices.items()}
        except (ValueError, TypeError, AttributeError, LookupError, RecursionError) as error:
            raise RecordingError(f"{path}: the line Dongles does not say where the receivers are") from error
        if not all(len(place) == 3 and all(map(isfinite, place)) for place in places.values()):
            raise RecordingError(f"{path}: the place of a receiver has to be three numbers")
        return {name: (place[0], place[1], place[2]) for name, place in places.items()}
    raise RecordingError(f"{path} has no line Dongles with the places of the receivers")


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise RecordingError(f"{path} is larger than {_MOST_BYTES} bytes")
        return path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"cannot read {path}: {error}") from error
