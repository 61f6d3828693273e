"""Ground that nobody told of and that is not worth going to: behind walls of what others covered.

Who covers ground calls its cells open where its edge is, so between covered cells and such as nobody told of
a wall stands. Its strip along covered ground, and what is left in small pieces between, cost robots more way
than they hold: most of it is ground that was covered after the tags were written.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from robots.exploration.told.survey import LATTICE_M
from robots.se2 import Array
from robots.tags.memory import CLOSED, UNSEEN

_PIECE_M2 = 3.0
_ROUND = np.ones((3, 3), bool)


def shaded(
    claimed: NDArray[np.uint8], unknown: Array, from_afar: bool, cell_m: float = 1.0
) -> NDArray[np.bool_]:
    """Return which cells are not worth going to, (r, c).

    Args:
        claimed: the states that tags tell, (r, c).
        unknown: how much of each cell the robot's own map does not know, (r, c).
        from_afar: tags are read from afar, so the edges that they tell of are still there: a single open cell
            may be the mouth of the corridor to all the rest. Read under a robot's feet, they tell of edges
            that their writer went to next.
        cell_m: of the cells that tags tell; each is covered from a quarter on.
    """
    told: NDArray[np.bool_] = claimed == CLOSED
    if not told.any():
        return told
    shade: NDArray[np.bool_] = (claimed == UNSEEN) & ndimage.binary_dilation(
        told, _ROUND, round(cell_m / LATTICE_M)
    )
    left = (unknown > 0.5) & ~told & ~shade
    if from_afar:
        left &= claimed == UNSEEN
    pieces, _ = ndimage.label(np.pad(left, 1, constant_values=True))  # beyond the lattice all is left
    sizes = np.bincount(pieces.ravel()) * LATTICE_M**2
    sizes[pieces[0, 0]] = np.inf
    shade |= left & (sizes[pieces] < _PIECE_M2)[1:-1, 1:-1]
    return shade
