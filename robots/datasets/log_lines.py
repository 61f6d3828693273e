"""The file of an exported mission log: gzip over lines of JSON, so that `zcat` shows it.

    {"waymark_log": 1, "mission_id", "name", "created_unix_s", "robots": how many}
    then for each robot
    {"robot_id", "agent", "start_pose": {"x_m", "y_m", "yaw_rad", "sd_m", "sd_rad"} or null, "config",
     "observations": how many, "updates_until": seq or null, "updates_sha256", "graph_sha256": hex or null}
    so many observations, one a line, as ``robots.codec`` writes them, byte for byte as they were stored; a
    line {"fault": reason} goes before one that the agent did not survive
    and at the very end
    {"end": how many lines went before}

``updates_sha256`` is the chained digest (``codec.chained``) of every update that the agent on the server made
up to the observation ``updates_until``; ``graph_sha256`` that of the latest tag graph which the server kept.
Both are what a replay has to come to.
"""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from robots.datasets.recording import RecordingError

VERSION = 1
_LONGEST_LINE = 16 * 2**20  # bytes: four times the longest that fits into a request


class LineWriter:
    """Turns lines into the bytes of the file, a piece at a time."""

    def __init__(self) -> None:
        self._gzip = zlib.compressobj(6, zlib.DEFLATED, 31)
        self._lines = 0

    def line(self, data: bytes) -> bytes:
        """Return the bytes that one more line adds, often none yet."""
        self._lines += 1
        return self._gzip.compress(data + b"\n")

    def value(self, value: dict[str, Any]) -> bytes:
        """Return the bytes that a line with a JSON object adds."""
        return self.line(json.dumps(value, separators=(",", ":")).encode())

    def end(self) -> bytes:
        """Return the bytes of the last line and of all that is still held back."""
        return self.value({"end": self._lines}) + self._gzip.flush()


def read_lines(path: Path) -> Iterator[bytes]:
    """Yield the lines before the last one; memory is bounded by one line, whatever the file says.

    Raises:
        RecordingError: the file cannot be read, is no mission log of this version, or is not whole.
    """
    count = 0
    try:
        with gzip.open(path, "rb") as file:
            while line := file.readline(_LONGEST_LINE + 1):
                if len(line) > _LONGEST_LINE:
                    raise RecordingError(f"{path}, line {count + 1}: longer than any that Waymark writes")
                if not count:
                    _check_version(path, line)
                if line.startswith(b'{"end":'):
                    if line != b'{"end":%d}\n' % count or file.read(1):
                        break
                    return
                yield line
                count += 1
    except FileNotFoundError as error:
        raise RecordingError(f"there is no mission log {path}") from error
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        if not count:
            raise RecordingError(f"{path} is no mission log that waymark export wrote") from error
        raise RecordingError(f"{path} is cut short or damaged; export it again") from error
    except OSError as error:
        raise RecordingError(f"cannot read the mission log {path}: {error.strerror or error}") from error
    raise RecordingError(f"{path} is cut short or damaged; export it again")


def json_object(path: Path, line: bytes) -> dict[str, Any]:
    """Return the object in a line.

    Raises:
        RecordingError: there is none.
    """
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        value = None
    if not isinstance(value, dict):
        raise RecordingError(f"{path} is damaged: a line is no JSON object")
    return value


def _check_version(path: Path, line: bytes) -> None:
    try:
        version = json.loads(line)["waymark_log"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise RecordingError(f"{path} is no mission log that waymark export wrote") from error
    if version != VERSION:
        raise RecordingError(
            f"{path} is a mission log of version {version!r:.20}; this program reads version {VERSION}"
        )
