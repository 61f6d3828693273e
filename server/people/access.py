"""The door: who a connection comes from."""

from __future__ import annotations

from starlette.requests import HTTPConnection

from db.store import Store
from server.errors import ApiError
from server.people.accounts import Accounts
from server.people.actor import Actor
from server.people.robot_tokens import RobotTokens

COOKIE = "waymark_session"
_BEARER = "bearer "
_ANYBODY = "operator"  # what people are called where nobody logs in


class Access:
    """Accounts and tokens; with ``is_open`` everybody on this machine may do everything unasked."""

    def __init__(self, store: Store, is_open: bool, robot_token: str | None) -> None:
        self.is_open = is_open
        self.accounts = Accounts(store)
        self.robot_tokens = RobotTokens(store, robot_token)
        self._anybody = Actor(_ANYBODY, "commander")

    async def restore(self) -> None:
        """Take over what the database holds."""
        await self.accounts.restore()
        await self.robot_tokens.restore()

    def actor_of(self, connection: HTTPConnection) -> Actor:
        """Return who it comes from: a robot by its token, a person by the session in its cookie.

        Raises:
            ApiError: nobody that is known.
        """
        authorization = connection.headers.get("authorization", "")
        if authorization[: len(_BEARER)].lower() == _BEARER:
            actor = self.robot_tokens.actor_of(authorization[len(_BEARER) :].strip())
            if actor is None:
                message = "This token is unknown or was revoked; ask a commander for another."
                raise ApiError(401, "wrong_token", message)
            return actor
        if self.is_open:
            return self._anybody
        secret = connection.cookies.get(COOKIE)
        actor = None if secret is None else self.accounts.actor_of(secret)
        if actor is None:
            raise ApiError(401, "not_logged_in", "Log in first; a robot shows its token.")
        return actor
