"""A console page's seat before a 3D view: what the page has selected goes in, what is clicked comes out.

A scene is shared by all who look, a selection is not. So each page names its seat by a secret of its own,
opens the view under that name, and the proxy tells viser with every socket whose it is.
"""

from __future__ import annotations

import asyncio
import contextlib
from dataclasses import dataclass, field

import viser

from web.viser.picking import Named

SEAT_HEADER = "X-Waymark-Seat"
"""The proxy alone sets it: a browser's own headers never reach viser."""
_MOST_CLICKS = 16


@dataclass(frozen=True, slots=True)
class Wish:
    """What a page wants of its view: what to mark, whether to go along with it, how often it was centred."""

    selected: Named | None = None
    follows: bool = False
    centred: int = 0


@dataclass(slots=True, eq=False)
class Seat:
    """One page's seat. ``over`` is set when its session ends, ``gone`` when the page takes it anew."""

    key: str
    over: asyncio.Event
    wish: Wish = Wish()
    gone: asyncio.Event = field(default_factory=asyncio.Event)
    _clicks: asyncio.Queue[Named] = field(default_factory=lambda: asyncio.Queue(_MOST_CLICKS))
    _loop: asyncio.AbstractEventLoop = field(default_factory=asyncio.get_running_loop)

    def click(self, named: Named) -> None:
        """Tell the page that something was clicked; from any thread."""
        self._loop.call_soon_threadsafe(self._put, named)

    async def clicked(self) -> Named:
        """Wait for a click; return kind and id of what it was on."""
        return await self._clicks.get()

    def _put(self, named: Named) -> None:
        with contextlib.suppress(asyncio.QueueFull):  # whoever clicks so fast means none of it
            self._clicks.put_nowait(named)


def seat_name(mission_id: str, secret: str) -> str:
    """Return a seat's key: no mission's id holds an @."""
    return f"{mission_id}@{secret}"


def is_seat(key: str) -> bool:
    """Say whether a key in an address is a seat's, not a mission's id."""
    return "@" in key


def mission_of(key: str) -> str:
    """Return the mission whose scene a key in an address stands for."""
    return key.partition("@")[0]


def seat_key(server: viser.ViserServer, client_id: int) -> str | None:
    """Return the seat that a viewer's socket was opened for, None for none.

    viser has no public way from a client to the request it came with; the contract test pins this one.
    """
    connection = server._websock_server._live_connections.get(client_id)
    request = None if connection is None else connection.request
    return None if request is None else request.headers.get(SEAT_HEADER)
