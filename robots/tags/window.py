"""Windows of cells of three states round a tag, and their bytes: five cells in one of them.

A window is uint8 (s, s), s odd; rows go north (x of the frame), columns west (y), the tag lies in the middle
cell. Its bytes hold the box round all cells that are not 0. A box only grows when windows are merged, so what
a window costs only grows, and letting go of outer rings until it fits keeps the laws of merging
(``memory.TagMemory.fit``). Codes that pack by content are shorter, but what they cost may shrink by a merge.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

Cells = NDArray[np.uint8]
_PER_BYTE = 5  # 3**5 = 243
_WEIGHTS = 3 ** np.arange(_PER_BYTE)


class WindowError(ValueError):
    """The bytes are no window."""


def no_cells() -> Cells:
    """Return the smallest window, which holds nothing."""
    return np.zeros((1, 1), np.uint8)


def resized(cells: Cells, side: int) -> Cells:
    """Return a window with rings of 0 put round it, or rings taken off."""
    more = (side - len(cells)) // 2
    if more <= 0:
        return cells[-more:more, -more:more] if more else cells
    wider = np.zeros((side, side), np.uint8)
    wider[more : side - more, more : side - more] = cells
    return wider


def trimmed(cells: Cells) -> Cells:
    """Return the window without outer rings that hold nothing."""
    middle = len(cells) // 2
    top, bottom, left, right = _box(cells)
    if bottom == 0:
        return no_cells()
    reach = max(middle - top, bottom - 1 - middle, middle - left, right - 1 - middle)
    return resized(cells, 2 * reach + 1)


def joined(first: Cells, second: Cells) -> Cells:
    """Return the greater state of every cell."""
    smaller, larger = (first, second) if len(first) <= len(second) else (second, first)
    both = larger.copy()
    _raise(both, smaller)
    return both


def within(cells: Cells, reach: int) -> Cells:
    """Return the window without the rings beyond so many cells from the middle."""
    return cells if len(cells) <= 2 * reach + 1 else resized(cells, 2 * reach + 1)


def cost(cells: Cells, reach: int) -> int:
    """Return the bytes of the window kept up to ``reach``; greater windows never cost less."""
    kept = within(cells, reach)
    if not kept.any():
        return 0
    top, bottom, left, right = _box(kept)
    return _box_bytes(reach) + int(-(-(bottom - top) * (right - left) // _PER_BYTE))


def fitting_reach(cells: Cells, most: int, room_bytes: int) -> int:
    """Return the greatest reach up to ``most`` at which the window has room; -1 where none has."""
    return int(_fitting_reach(cells, most, room_bytes, _box_sizes(most)))


def pack(cells: Cells, reach: int) -> bytes:
    """Return the bytes of a window that holds something and nothing beyond ``reach``."""
    full = resized(cells, 2 * reach + 1)
    top, bottom, left, right = box = _box(full)
    number = 0
    for edge in (box[0], box[1] - 1, box[2], box[3] - 1):
        number = number * len(full) + edge
    flat = full[top:bottom, left:right].ravel().astype(np.int64)
    padded = np.zeros(-(-len(flat) // _PER_BYTE) * _PER_BYTE, np.int64)
    padded[: len(flat)] = flat
    digits: Cells = (padded.reshape(-1, _PER_BYTE) @ _WEIGHTS).astype(np.uint8)
    return number.to_bytes(_box_bytes(reach), "big") + digits.tobytes()


def unpack(data: bytes, reach: int) -> tuple[Cells, int]:
    """Return the window at the beginning of the bytes, and how many of them it took.

    Raises:
        WindowError: they end too early, or are not what ``pack`` writes.
    """
    side, at = 2 * reach + 1, _box_bytes(reach)
    number, edges = int.from_bytes(data[:at], "big"), []
    for _ in range(4):
        number, edge = divmod(number, side)
        edges.append(edge)
    right, left, bottom, top = edges
    height, width = bottom - top + 1, right - left + 1
    if number or height < 1 or width < 1:
        raise WindowError("its window has no such box")
    end = at + -(-height * width // _PER_BYTE)
    if len(data) < end:
        raise WindowError(f"it ends after {len(data)} bytes of a window of {end}")
    packed = np.frombuffer(data[at:end], np.uint8)
    if (packed > 242).any():
        raise WindowError("a cell has a state that does not exist")
    digits = _digits()[packed].ravel()
    if digits[height * width :].any():
        raise WindowError("there are cells beyond its window")
    cells = np.zeros((side, side), np.uint8)
    cells[top : bottom + 1, left : right + 1] = digits[: height * width].reshape(height, width)
    if _box(cells) != (top, bottom + 1, left, right + 1):
        raise WindowError("its window is larger than what it holds")
    return trimmed(cells), end


@njit(cache=True)
def _raise(cells: Cells, to: Cells) -> None:
    """Take the greater state of each cell of a window no larger, whose middle is the same."""
    ring = (len(cells) - len(to)) // 2
    for r in range(len(to)):
        for c in range(len(to)):
            cells[ring + r, ring + c] = max(cells[ring + r, ring + c], to[r, c])


@njit(cache=True)
def _box(cells: Cells) -> tuple[int, int, int, int]:
    """Return the first and the end of the rows and of the columns that hold something; all 0 for none."""
    rows, columns = cells.shape
    top, bottom, left, right = rows, 0, columns, 0
    for r in range(rows):
        for c in range(columns):
            if cells[r, c]:
                top, bottom = min(top, r), r + 1
                left, right = min(left, c), max(right, c + 1)
    if bottom == 0:
        return 0, 0, 0, 0
    return top, bottom, left, right


@njit(cache=True)
def _fitting_reach(cells: Cells, most: int, room_bytes: int, box_bytes: NDArray[np.int64]) -> int:
    middle = len(cells) // 2
    first = np.full((most + 1, 2), len(cells))  # row and column, of each ring alone
    last = np.full((most + 1, 2), -1)
    for r in range(len(cells)):
        for c in range(len(cells)):
            ring = max(abs(r - middle), abs(c - middle))
            if cells[r, c] and ring <= most:
                first[ring, 0], last[ring, 0] = min(first[ring, 0], r), max(last[ring, 0], r)
                first[ring, 1], last[ring, 1] = min(first[ring, 1], c), max(last[ring, 1], c)
    best, top, left, bottom, right = -1, len(cells), len(cells), -1, -1
    for reach in range(most + 1):
        if last[reach, 0] >= 0:
            top, left = min(top, first[reach, 0]), min(left, first[reach, 1])
            bottom, right = max(bottom, last[reach, 0]), max(right, last[reach, 1])
        size = 0
        if bottom >= 0:
            size = box_bytes[reach] + -(-(bottom + 1 - top) * (right + 1 - left) // _PER_BYTE)
        if size > room_bytes:  # the cost grows with the reach
            break
        best = reach
    return best


@lru_cache(maxsize=8)
def _box_sizes(most: int) -> NDArray[np.int64]:
    return np.array([_box_bytes(reach) for reach in range(most + 1)], np.int64)


def _box_bytes(reach: int) -> int:
    return -(-(((2 * reach + 1) ** 4 - 1).bit_length()) // 8)


@lru_cache(maxsize=1)
def _digits() -> Cells:
    """The five cells of every byte, (243, 5)."""
    return (np.arange(243)[:, None] // _WEIGHTS % 3).astype(np.uint8)
