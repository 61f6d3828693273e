"""Robots' tokens: made by people, shown by robots with every request, revoked at any time."""

from __future__ import annotations

import asyncio
import time
import uuid
from dataclasses import replace

from db.people_records import RobotTokenRecord
from db.store import Store
from server.errors import unknown
from server.people.actor import Actor
from server.people.secrets import digest, new_secret


class RobotTokens:
    """All tokens. ``given`` is one that the environment names; it is for every mission and robot."""

    def __init__(self, store: Store, given: str | None) -> None:
        self._store = store.people
        self._given = None if given is None else digest(given)
        self._by_secret: dict[str, RobotTokenRecord] = {}
        self._over: dict[str, asyncio.Event] = {}

    async def restore(self) -> None:
        """Take over what the database holds."""
        self._by_secret = {t.secret_sha256: t for t in await self._store.all_robot_tokens()}

    def all(self) -> list[RobotTokenRecord]:
        """Return the tokens, revoked ones too, oldest first."""
        return list(self._by_secret.values())

    def actor_of(self, secret: str) -> Actor | None:
        """Return whom a token stands for; None where it is none, or revoked."""
        key = digest(secret)
        if key == self._given:
            return Actor("robots of this machine", "robot")
        token = self._by_secret.get(key)
        if token is None or token.revoked_unix_s is not None:
            return None
        over = self._over.setdefault(token.token_id, asyncio.Event())
        return Actor(token.label, "robot", token.mission_id, token.robot_id, over)

    async def make(
        self, label: str, mission_id: str | None, robot_id: str | None, by: str
    ) -> tuple[str, RobotTokenRecord]:
        """Make a token; return its secret, which is not kept."""
        secret = new_secret()
        token = RobotTokenRecord(
            uuid.uuid4().hex, digest(secret), label, mission_id, robot_id, by, time.time()
        )
        await self._store.add_robot_token(token)
        self._by_secret[token.secret_sha256] = token
        return secret, token

    async def revoke(self, token_id: str) -> RobotTokenRecord:
        """Let a token count no more, at once; return it.

        Raises:
            ApiError: there is none of that id.
        """
        found = [token for token in self._by_secret.values() if token.token_id == token_id]
        if not found:
            raise unknown("token", token_id)
        if found[0].revoked_unix_s is not None:
            return found[0]
        token = replace(found[0], revoked_unix_s=time.time())
        self._by_secret[token.secret_sha256] = token  # before it is saved: it may be in the wrong hands
        self._over.pop(token_id, asyncio.Event()).set()
        await self._store.revoke_robot_token(token_id, token.revoked_unix_s or 0.0)
        return token
