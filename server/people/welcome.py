"""The first start: a link with which one person becomes commander."""

from __future__ import annotations

from server.people.accounts import LINK_S, Accounts
from server.settings import Settings


async def welcome(accounts: Accounts, settings: Settings) -> None:
    """Print a one-time link where nobody could log in as commander, or where one was asked for."""
    if settings.login == "off" or (accounts.has_commander and not settings.commander_link):
        return
    secret, _ = await accounts.make_link("commander", "the server")
    hours = round(LINK_S / 3600.0)
    print(
        f"Become commander with this link, once and within {hours} h: {settings.address}/join#{secret}",
        flush=True,
    )
