"""Which part of a grid changed since somebody looked."""

from __future__ import annotations

from collections import deque

Rectangle = tuple[int, int, int, int]  # first row and column, and those after the last

_KEPT = 256


class Changes:
    """The latest changes of a grid as rectangles of cells; each makes a new ``revision``."""

    def __init__(self) -> None:
        self.revision = 0
        self._rectangles: deque[Rectangle] = deque(maxlen=_KEPT)

    def note(self, top: int, left: int, bottom: int, right: int) -> None:
        """Note that cells from (top, left) up to but not with (bottom, right) may have changed."""
        self.revision += 1
        self._rectangles.append((top, left, bottom, right))

    def since(self, revision: int) -> Rectangle | None:
        """Return the rectangle round all changes since a revision, empty where there are none.

        None where they are no longer known.
        """
        count = self.revision - revision
        if count == 0:
            return 0, 0, 0, 0
        if not 0 < count <= len(self._rectangles):
            return None
        newest = [self._rectangles[-k] for k in range(1, count + 1)]
        tops, lefts, bottoms, rights = zip(*newest, strict=True)
        return min(tops), min(lefts), max(bottoms), max(rights)
