"""Accounts: people join by a one-time link, log in, and get a session."""

from __future__ import annotations

import asyncio
import time
import uuid
from dataclasses import dataclass, field, replace

from db.people_records import AccountRecord, LinkRecord, Role, SessionRecord
from db.store import Store
from server.errors import ApiError, unknown
from server.people.actor import Actor
from server.people.attempts import Attempts
from server.people.secrets import digest, hash_password, is_password, new_secret

SESSION_S = 7 * 24 * 3600.0  # longer than any operation goes without a change of shifts
LINK_S = 24 * 3600.0
_NOBODY = hash_password(new_secret())  # compared with where there is no such account: it takes as long


@dataclass(slots=True)
class _Session:
    record: SessionRecord
    over: asyncio.Event = field(default_factory=asyncio.Event)


class Accounts:
    """All accounts, their sessions, and the links by which people join."""

    def __init__(self, store: Store) -> None:
        self._store = store.people
        self._accounts: dict[str, AccountRecord] = {}
        self._sessions: dict[str, _Session] = {}
        self._links: dict[str, LinkRecord] = {}
        self._attempts = Attempts()
        self._hashing = asyncio.Semaphore(1)  # each try takes 16 MB and a core for a while
        self._changing = asyncio.Lock()

    async def restore(self) -> None:
        """Take over what the database holds."""
        self._accounts = {account.account_id: account for account in await self._store.all_accounts()}
        self._sessions = {s.secret_sha256: _Session(s) for s in await self._store.all_sessions()}
        self._links = {link.secret_sha256: link for link in await self._store.all_links()}

    def all(self) -> list[AccountRecord]:
        """Return the accounts, oldest first."""
        return list(self._accounts.values())

    @property
    def has_commander(self) -> bool:
        """Whether anybody can log in who may do everything."""
        return any(a.role == "commander" and not a.disabled for a in self._accounts.values())

    def actor_of(self, secret: str) -> Actor | None:
        """Return whose session it is; None where it is none, or over."""
        session = self._sessions.get(digest(secret))
        if session is None or session.record.expires_unix_s < time.time():
            return None
        account = self._accounts[session.record.account_id]
        return None if account.disabled else Actor(account.name, account.role, over=session.over)

    async def make_link(self, role: Role, by: str) -> tuple[str, LinkRecord]:
        """Make a one-time link; return its secret, which is not kept."""
        secret, now = new_secret(), time.time()
        link = LinkRecord(digest(secret), role, by, now, now + LINK_S)
        await self._store.add_link(link)
        self._links[link.secret_sha256] = link
        return secret, link

    async def join(self, secret: str, name: str, password: str) -> tuple[str, AccountRecord]:
        """Make an account by a link and log in; return the session's secret.

        Raises:
            ApiError: the link is none, used or too old; or the name is taken.
        """
        self._link(secret)  # or anybody could keep a core busy with hashing
        password_hash = await self._hashed(password)
        async with self._changing:
            link = self._link(secret)  # somebody may have used it meanwhile
            if any(account.name.casefold() == name.casefold() for account in self._accounts.values()):
                message = f"Somebody is called {name} already; take another name, or log in."
                raise ApiError(409, "name_taken", message, "name")
            account = AccountRecord(uuid.uuid4().hex, name, link.role, password_hash, time.time())
            await self._store.add_account(account, link.secret_sha256)
            del self._links[link.secret_sha256]
            self._accounts[account.account_id] = account
        return await self._begin(account), account

    def _link(self, secret: str) -> LinkRecord:
        link = self._links.get(digest(secret))
        if link is None or link.expires_unix_s < time.time():
            message = "This link has been used or is too old; ask a commander for a new one."
            raise ApiError(403, "link_over", message)
        return link

    async def log_in(self, name: str, password: str, sender: str) -> tuple[str, AccountRecord]:
        """Begin a session; return its secret.

        Raises:
            ApiError: name or password are wrong, or too many tries were.
        """
        # a name alone must not be locked by others' wrong tries: its owner may be needed now
        keys = f"{name.casefold()} from {sender}", f"from {sender}"
        self._attempts.check(*keys)
        found = [a for a in self._accounts.values() if a.name.casefold() == name.casefold()]
        account = found[0] if found and not found[0].disabled else None
        async with self._hashing:
            kept = _NOBODY if account is None else account.password
            right = await asyncio.to_thread(is_password, password, kept)
        if account is None or not right:
            self._attempts.wrong(*keys)
            raise ApiError(401, "wrong_password", "The name or the password is wrong; try again.")
        self._attempts.right(*keys)
        return await self._begin(account), account

    async def log_out(self, secret: str) -> None:
        """End a session; one that is none does no harm."""
        session = self._sessions.pop(digest(secret), None)
        if session is not None:
            session.over.set()
            await self._store.end_session(session.record.secret_sha256)

    async def change(
        self, account_id: str, role: Role | None, disabled: bool | None, password: str | None
    ) -> tuple[AccountRecord, AccountRecord]:
        """Change an account and end its sessions; return it before and after.

        Raises:
            ApiError: there is none, or nobody would be left who may do everything.
        """
        password_hash = None if password is None else await self._hashed(password)
        async with self._changing:
            if account_id not in self._accounts:
                raise unknown("account", account_id)
            before = self._accounts[account_id]
            after = replace(
                before,
                role=before.role if role is None else role,
                disabled=before.disabled if disabled is None else disabled,
                password=before.password if password_hash is None else password_hash,
            )
            left = {**self._accounts, account_id: after}.values()
            if not any(a.role == "commander" and not a.disabled for a in left):
                message = "Nobody would be left who is a commander; make another person one first."
                raise ApiError(409, "last_commander", message)
            await self._store.change_account(after)
            self._accounts[account_id] = after
            self._end_sessions(account_id)
        return before, after

    async def _begin(self, account: AccountRecord) -> str:
        secret, now = new_secret(), time.time()
        session = SessionRecord(digest(secret), account.account_id, now, now + SESSION_S)
        await self._store.add_session(session)
        self._sessions = {k: s for k, s in self._sessions.items() if s.record.expires_unix_s >= now}
        self._sessions[session.secret_sha256] = _Session(session)
        return secret

    async def _hashed(self, password: str) -> str:
        async with self._hashing:
            return await asyncio.to_thread(hash_password, password)

    def _end_sessions(self, account_id: str) -> None:
        for key, session in list(self._sessions.items()):
            if session.record.account_id == account_id:
                del self._sessions[key]
                session.over.set()
