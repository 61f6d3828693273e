"""The mission in 3D over time, made in a process of its own and of low priority: it takes many seconds."""

from __future__ import annotations

import asyncio
import os
import sys
from io import BytesIO

import msgspec
import numpy as np
from PIL import Image

from db.store import Store
from server.errors import ApiError
from server.history.changes import Value
from server.history.past import Past, steps
from server.map_image import FREE, OCCUPIED
from web.viser.map_layer import Cells, Grid
from web.viser.recording import record

_NICE = 15
_LONGEST_S = 600.0


class _Material(msgspec.Struct):
    """What the process is given: chunks, oldest first, their length, and pictures by version of the map."""

    chunks: list[bytes]
    length_s: float
    pictures: dict[int, bytes]


def cells_of(png: bytes) -> Cells:
    """Return a map's picture as a grid (h, w) of -1 unknown, 0 free, 100 occupied; row 0 at the lowest y."""
    classes = np.asarray(Image.open(BytesIO(png)))[::-1]
    cells = np.full(classes.shape, -1, np.int8)
    cells[classes == FREE] = 0
    cells[classes == OCCUPIED] = 100
    return cells


def grid_of(shown: Value, png: bytes) -> Grid:
    """Return the grid of ``map`` of the board and its picture."""
    x_m, y_m = shown["origin_m"]
    return Grid(cells_of(png), (float(x_m), float(y_m)), float(shown["resolution_m"]))


async def make_film(store: Store, mission_id: str) -> bytes:
    """Return a mission's recording for viser's player.

    Raises:
        ApiError: nothing is recorded yet, or it could not be made.
        DatabaseError: the database cannot be read.
    """
    past = Past(store, mission_id)
    length_s = sum(span.ends_unix_s - span.begins_unix_s for span in await past.spans())
    material = _Material(
        [chunk async for chunk in past.chunks()], length_s, await store.history.pictures_of(mission_id)
    )
    if not material.chunks:
        raise ApiError(
            404, "no_history", "Nothing of this mission is recorded yet; it comes with its first second."
        )
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "server.history.film",
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
    )
    try:
        given = await asyncio.to_thread(msgspec.msgpack.encode, material)
        film, _ = await asyncio.wait_for(process.communicate(given), _LONGEST_S)
    except (TimeoutError, asyncio.CancelledError):
        process.kill()
        raise
    if process.returncode or not film:
        raise ApiError(500, "no_film", "The recording could not be made; the server's log says why.")
    return film


def main() -> None:
    """Make a recording of the material on stdin, and write it to stdout."""
    os.nice(_NICE)
    out = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever is printed is no part of the file
    material = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=_Material)

    def grid(shown: Value) -> Grid | None:
        png = material.pictures.get(shown["version"])
        return None if png is None else grid_of(shown, png)

    with out:
        out.write(
            record((step for chunk in material.chunks for step in steps(chunk)), grid, material.length_s)
        )


if __name__ == "__main__":
    main()
