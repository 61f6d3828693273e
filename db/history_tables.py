"""Tables of the past of missions: sealed chunks, lines of the one that is being written, and map pictures."""

from sqlalchemy import Column, Float, ForeignKeyConstraint, Integer, LargeBinary, Table, Text

from db.schema import ID, NUMBER, metadata

history_chunks = Table(
    "history_chunks",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("begins_unix_s", Float, nullable=False),
    Column("ends_unix_s", Float, nullable=False),  # of the last change in it
    Column("body", LargeBinary, nullable=False),  # gzip of JSON: see server.history.changes
    ForeignKeyConstraint(["mission_id"], ["missions.mission_id"]),
)

history_lines = Table(
    "history_lines",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("chunk", Integer, primary_key=True, autoincrement=False),
    Column("line", Integer, primary_key=True, autoincrement=False),
    Column("unix_s", Float, nullable=False),
    Column("body", Text, nullable=False),
    ForeignKeyConstraint(["mission_id"], ["missions.mission_id"]),
)

history_maps = Table(
    "history_maps",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("version", NUMBER, primary_key=True, autoincrement=False),
    Column("png", LargeBinary, nullable=False),
    ForeignKeyConstraint(["mission_id"], ["missions.mission_id"]),
)
