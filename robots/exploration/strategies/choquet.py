"""The Choquet integral: a weighted mean in which groups of criteria have weights of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robots.se2 import Array


class Capacity:
    """A normalised fuzzy measure on a set of criteria: of no criteria 0, of all 1, of more never less.

    Raises:
        ValueError: a group is missing or unknown, or it is no capacity.
    """

    def __init__(self, criteria: Sequence[str], weights: Mapping[frozenset[str], float]) -> None:
        self.criteria = tuple(criteria)
        self._bit = {name: 1 << k for k, name in enumerate(self.criteria)}
        size = 1 << len(self.criteria)
        self._mu = np.full(size, np.nan)
        self._mu[0], self._mu[-1] = 0.0, 1.0
        for group, weight in weights.items():
            if not group <= set(self.criteria):
                raise ValueError(f"the group {sorted(group)} names a criterion that there is not")
            self._mu[self._mask(group)] = weight
        if np.isnan(self._mu).any():
            raise ValueError("every group of criteria needs a weight")
        grown = [(a, a | bit) for a in range(size) for bit in self._bit.values()]
        if any(self._mu[less] > self._mu[more] for less, more in grown) or self._mu[-1] != 1.0:
            raise ValueError("a group of criteria weighs more than a larger one; no capacity does")

    def _mask(self, group: frozenset[str]) -> int:
        return sum(self._bit[name] for name in group)

    def integral(self, utilities: Array) -> Array:
        """Return the Choquet integral, (n,), of utilities (n, criteria), in the order of the criteria.

        Amigoni 2013 eq. (2): sorted upwards, each step counts with the measure of the criteria that reach it.
        """
        order = np.argsort(utilities, axis=1, kind="stable")
        rising = np.take_along_axis(utilities, order, axis=1)
        steps = np.diff(rising, axis=1, prepend=0.0)  # u_(j) - u_(j-1)
        bits = 1 << order
        reaching = bits[:, ::-1].cumsum(axis=1)[:, ::-1]  # A_(j)
        total: Array = (steps * self._mu[reaching]).sum(axis=1)  # (2)
        return total
