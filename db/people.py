"""People: accounts, sessions, one-time links, robots' tokens, and the audit log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, TypeVar

from sqlalchemy import Connection, Table, delete, insert, select, update

from db.engine import Database
from db.people_records import AccountRecord, AuditRecord, LinkRecord, RobotTokenRecord, SessionRecord
from db.people_tables import accounts, audit, links, robot_tokens, sessions

R = TypeVar("R")


class PeopleStore:
    """Who may do what, and who did what. Everything is on the disk before a method returns."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def all_accounts(self) -> list[AccountRecord]:
        """Return every account, oldest first."""
        return await self._all(accounts, AccountRecord)

    async def all_sessions(self) -> list[SessionRecord]:
        """Return every session, oldest first."""
        return await self._all(sessions, SessionRecord)

    async def all_links(self) -> list[LinkRecord]:
        """Return every link that nobody has used, oldest first."""
        return await self._all(links, LinkRecord)

    async def all_robot_tokens(self) -> list[RobotTokenRecord]:
        """Return every robot's token, also revoked ones, oldest first."""
        return await self._all(robot_tokens, RobotTokenRecord)

    async def add_account(self, account: AccountRecord, link: str | None) -> None:
        """Add an account and use up the link it was made with, both or neither."""

        def work(connection: Connection) -> None:
            connection.execute(insert(accounts).values(asdict(account)))
            if link is not None:
                connection.execute(delete(links).where(links.c.secret_sha256 == link))

        await self._database.write(work, durable=True)

    async def change_account(self, account: AccountRecord) -> None:
        """Keep a changed account; its sessions are over."""
        chosen = accounts.c.account_id == account.account_id

        def work(connection: Connection) -> None:
            connection.execute(update(accounts).where(chosen).values(asdict(account)))
            connection.execute(delete(sessions).where(sessions.c.account_id == account.account_id))

        await self._database.write(work, durable=True)

    async def add_session(self, session: SessionRecord) -> None:
        """Add a session, and forget those that had expired when it began."""

        def work(connection: Connection) -> None:
            connection.execute(delete(sessions).where(sessions.c.expires_unix_s < session.created_unix_s))
            connection.execute(insert(sessions).values(asdict(session)))

        await self._database.write(work, durable=True)

    async def end_session(self, secret_sha256: str) -> None:
        """Forget a session."""
        await self._database.write(
            lambda c: c.execute(delete(sessions).where(sessions.c.secret_sha256 == secret_sha256)),
            durable=True,
        )

    async def add_link(self, link: LinkRecord) -> None:
        """Add a one-time link, and forget those that had expired when it was made."""

        def work(connection: Connection) -> None:
            connection.execute(delete(links).where(links.c.expires_unix_s < link.created_unix_s))
            connection.execute(insert(links).values(asdict(link)))

        await self._database.write(work, durable=True)

    async def add_robot_token(self, token: RobotTokenRecord) -> None:
        """Add a token."""
        await self._database.write(
            lambda c: c.execute(insert(robot_tokens).values(asdict(token))), durable=True
        )

    async def revoke_robot_token(self, token_id: str, unix_s: float) -> None:
        """Keep that a token counts no more."""
        chosen = robot_tokens.c.token_id == token_id
        await self._database.write(
            lambda c: c.execute(update(robot_tokens).where(chosen).values(revoked_unix_s=unix_s)),
            durable=True,
        )

    async def note(self, record: AuditRecord) -> AuditRecord:
        """Add a change to the audit log; return it with its number."""
        row = asdict(record)
        row.pop("audit_id")

        def work(connection: Connection) -> int:
            key = connection.execute(insert(audit).values(row)).inserted_primary_key
            return int(key[0]) if key is not None else 0

        number = await self._database.write(work, durable=True)
        return AuditRecord(**{**asdict(record), "audit_id": number})

    async def audit_of(self, mission_id: str | None, before: int | None, limit: int) -> list[AuditRecord]:
        """Return changes, newest first: of a mission, None for all of them; older than number ``before``."""
        query = select(audit).order_by(audit.c.audit_id.desc()).limit(limit)
        if mission_id is not None:
            query = query.where(audit.c.mission_id == mission_id)
        if before is not None:
            query = query.where(audit.c.audit_id < before)
        return await self._database.read(lambda c: [AuditRecord(**row._mapping) for row in c.execute(query)])

    async def audit_entry(self, mission_id: str, audit_id: int) -> AuditRecord | None:
        """Return one change of a mission; None where there is none."""
        query = select(audit).where(audit.c.audit_id == audit_id, audit.c.mission_id == mission_id)

        def read(connection: Connection) -> AuditRecord | None:
            row = connection.execute(query).first()
            return None if row is None else AuditRecord(**row._mapping)

        return await self._database.read(read)

    async def _all(self, table: Table, record: type[R]) -> list[R]:
        query = select(table).order_by(table.c.created_unix_s)

        def read(connection: Connection) -> list[R]:
            rows: Sequence[Any] = connection.execute(query).all()
            return [record(**row._mapping) for row in rows]

        return await self._database.read(read)
