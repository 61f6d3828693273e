"""Slowing down whoever guesses passwords."""

from __future__ import annotations

import time
from collections import OrderedDict

from server.errors import ApiError

_FREE = 5  # wrong tries before anybody has to wait
_FIRST_WAIT_S, _LONGEST_WAIT_S = 2.0, 300.0
_REMEMBERED = 10_000


class Attempts:
    """Counts wrong tries by what they were at: an account's name, or the address they come from."""

    def __init__(self) -> None:
        self._wrong: OrderedDict[str, tuple[int, float]] = OrderedDict()  # how many, and wait until

    def check(self, *keys: str) -> None:
        """Refuse to try again so soon.

        Raises:
            ApiError: one of the keys has to wait.
        """
        left_s = max(self._wrong.get(key, (0, 0.0))[1] for key in keys) - time.monotonic()
        if left_s > 0.0:
            seconds = int(left_s) + 1
            message = f"Too many wrong tries; try again in {seconds} s."
            raise ApiError(429, "too_many_tries", message, retry_after_s=seconds)

    def wrong(self, *keys: str) -> None:
        """Note a wrong try: from the sixth on the wait doubles with each."""
        for key in keys:
            count = self._wrong.pop(key, (0, 0.0))[0] + 1
            wait_s = min(_FIRST_WAIT_S * 2.0 ** min(count - _FREE, 20), _LONGEST_WAIT_S)
            until = time.monotonic() + wait_s if count > _FREE else 0.0
            self._wrong[key] = (count, until)
            if len(self._wrong) > _REMEMBERED:
                self._wrong.popitem(last=False)

    def right(self, *keys: str) -> None:
        """Forget the wrong tries."""
        for key in keys:
            self._wrong.pop(key, None)
