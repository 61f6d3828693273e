"""What the store hands out of people: frozen values, one per row; secrets only as their SHA-256."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Role = Literal["viewer", "responder", "operator", "commander"]


@dataclass(frozen=True, slots=True)
class AccountRecord:
    """A person. ``password`` is a hash with its salt and cost."""

    account_id: str
    name: str
    role: Role
    password: str
    created_unix_s: float
    disabled: bool = False


@dataclass(frozen=True, slots=True)
class SessionRecord:
    """A browser somebody has logged in with."""

    secret_sha256: str
    account_id: str
    created_unix_s: float
    expires_unix_s: float


@dataclass(frozen=True, slots=True)
class LinkRecord:
    """An invitation: whoever opens it first makes an account of this role."""

    secret_sha256: str
    role: Role
    by: str
    created_unix_s: float
    expires_unix_s: float


@dataclass(frozen=True, slots=True)
class RobotTokenRecord:
    """What a robot shows; for one mission or all (None), for one robot or all (None)."""

    token_id: str
    secret_sha256: str
    label: str
    mission_id: str | None
    robot_id: str | None
    by: str
    created_unix_s: float
    revoked_unix_s: float | None = None


@dataclass(frozen=True, slots=True)
class AuditRecord:
    """A change: who did what to what. ``before`` and ``after`` where it can be undone."""

    audit_id: int
    unix_s: float
    mission_id: str | None
    by: str
    role: str
    action: str
    subject: str
    before: dict[str, Any] | None = None
    after: dict[str, Any] | None = None
