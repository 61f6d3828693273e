"""The tables of how missions go: what is left of a closed one, and how they got on."""

from sqlalchemy import JSON, Column, Float, ForeignKeyConstraint, Integer, LargeBinary, Table

from db.schema import ID, metadata


def _of_mission() -> ForeignKeyConstraint:
    return ForeignKeyConstraint(["mission_id"], ["missions.mission_id"])


endings = Table(
    "endings",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("ended_unix_s", Float, nullable=False),
    Column("board", JSON, nullable=False),  # keys and values that no other table holds
    Column("grid", LargeBinary),  # robots.codec of TeamGrid; NULL where there was no map
    _of_mission(),
)

progress = Table(
    "progress",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("unix_s", Float, primary_key=True),
    Column("clock_s", Float, nullable=False),  # the robots' own
    Column("explored_m2", Float, nullable=False),
    Column("tags", Integer, nullable=False),
    Column("victims", Integer, nullable=False),
    _of_mission(),
)
