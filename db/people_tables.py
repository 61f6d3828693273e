"""The tables of people: accounts, sessions, one-time links, robots' tokens, and the audit log."""

from sqlalchemy import JSON, Boolean, Column, Float, ForeignKeyConstraint, Index, String, Table, Text

from db.schema import ID, NUMBER, metadata

accounts = Table(
    "accounts",
    metadata,
    Column("account_id", ID, primary_key=True),
    Column("name", String(60), nullable=False, unique=True),
    Column("role", String(20), nullable=False),  # viewer | responder | operator | commander
    Column("password", String(200), nullable=False),  # scrypt$cost$salt$hash
    Column("created_unix_s", Float, nullable=False),
    Column("disabled", Boolean, nullable=False),
)

sessions = Table(
    "sessions",
    metadata,
    Column("secret_sha256", String(64), primary_key=True),
    Column("account_id", ID, nullable=False),
    Column("created_unix_s", Float, nullable=False),
    Column("expires_unix_s", Float, nullable=False),
    ForeignKeyConstraint(["account_id"], ["accounts.account_id"]),
)

links = Table(
    "links",
    metadata,
    Column("secret_sha256", String(64), primary_key=True),
    Column("role", String(20), nullable=False),
    Column("by", String(60), nullable=False),
    Column("created_unix_s", Float, nullable=False),
    Column("expires_unix_s", Float, nullable=False),
)

robot_tokens = Table(
    "robot_tokens",
    metadata,
    Column("token_id", ID, primary_key=True),
    Column("secret_sha256", String(64), nullable=False, unique=True),
    Column("label", String(200), nullable=False),
    Column("mission_id", ID),  # NULL: any mission, and it may open one
    Column("robot_id", ID),  # NULL: any robot
    Column("by", String(60), nullable=False),
    Column("created_unix_s", Float, nullable=False),
    Column("revoked_unix_s", Float),
)

audit = Table(
    "audit",
    metadata,
    Column("audit_id", NUMBER, primary_key=True, autoincrement=True),
    Column("unix_s", Float, nullable=False),
    Column("mission_id", ID),
    Column("by", String(60), nullable=False),
    Column("role", String(20), nullable=False),
    Column("action", String(60), nullable=False),
    Column("subject", Text, nullable=False),
    Column("before", JSON(none_as_null=True)),
    Column("after", JSON(none_as_null=True)),
    Index("ix_audit_mission_id", "mission_id", "audit_id"),
)
