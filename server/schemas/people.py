"""Accounts, sessions, links, robots' tokens and the audit log on the wire."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field

from db.people_records import Role
from server.schemas.common import Name, Wire


def _is_a_name(text: str) -> str:
    if text != " ".join(text.split()) or not text.isprintable():
        raise ValueError("has to be printable, with single spaces inside only")
    return text


PersonName = Annotated[
    str, Field(min_length=1, max_length=60, description="What others see."), AfterValidator(_is_a_name)
]
Password = Annotated[str, Field(min_length=8, max_length=200, description="At least eight characters.")]
Secret = Annotated[str, Field(min_length=1, max_length=200, description="The part of the link after the #.")]


class LoginIn(Wire):
    """Who logs in."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"name": "Ada", "password": "correct horse"}]})

    name: PersonName
    password: Annotated[str, Field(min_length=1, max_length=200)]


class JoinIn(Wire):
    """Who joins by a one-time link."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"secret": "...", "name": "Ben", "password": "battery staple"}]}
    )

    secret: Secret
    name: PersonName
    password: Password


class MeOut(Wire):
    """Who you are. ``login``: whether people log in here at all."""

    name: str
    role: str = Field(description="viewer, responder, operator, commander; robot for a robot's token.")
    login: bool


class LinkIn(Wire):
    """Whom a link is for."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"role": "operator"}]})

    role: Role


class LinkOut(Wire):
    """A one-time link. It is told once."""

    path: str = Field(description="Behind this server's address.", examples=["/join#..."])
    role: Role
    expires_unix_s: float


class AccountIn(Wire):
    """What to change of an account; null leaves it. Whoever it is has to log in again."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"role": "operator"}, {"disabled": True}]})

    role: Role | None = None
    disabled: bool | None = None
    password: Password | None = None


class AccountOut(Wire):
    """A person."""

    account_id: str
    name: str
    role: Role
    created_unix_s: float
    disabled: bool


class AccountsOut(Wire):
    """All accounts, oldest first."""

    accounts: list[AccountOut]


class RobotTokenIn(Wire):
    """A token to make; null for all missions, or all robots."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"label": "red rover", "mission_id": "school-1", "robot_id": "r1"}]}
    )

    label: PersonName
    mission_id: Name | None = None
    robot_id: Name | None = None


class RobotTokenOut(Wire):
    """A token, without its secret."""

    token_id: str
    label: str
    mission_id: str | None
    robot_id: str | None
    by: str
    created_unix_s: float
    revoked_unix_s: float | None


class NewRobotTokenOut(RobotTokenOut):
    """A token with its secret, which is told once."""

    token: str = Field(description="To be sent as `Authorization: Bearer TOKEN`.")


class RobotTokensOut(Wire):
    """All tokens, oldest first."""

    tokens: list[RobotTokenOut]


class AuditEntryOut(Wire):
    """A change."""

    audit_id: int
    unix_s: float
    mission_id: str | None
    by: str
    role: str
    action: str
    subject: str
    before: dict[str, Any] | None
    after: dict[str, Any] | None


class AuditOut(Wire):
    """Changes, newest first."""

    entries: list[AuditEntryOut]
