"""The tables of how missions go: what is left of a closed one, how they got on, and photos."""

from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    Float,
    ForeignKeyConstraint,
    Integer,
    LargeBinary,
    String,
    Table,
    Text,
)

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

photos = Table(
    "photos",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("photo_id", String(36), primary_key=True),
    Column("sha256", String(64), nullable=False),
    Column("width", Integer, nullable=False),
    Column("height", Integer, nullable=False),
    Column("text", Text, nullable=False),
    Column("victim_id", ID),
    Column("annotation_id", String(36)),
    Column("tag_id", ID),
    Column("x_m", Float),
    Column("y_m", Float),
    Column("by", String(200), nullable=False),
    Column("taken_unix_s", Float),
    Column("created_unix_s", Float, nullable=False),
    Column("whole", LargeBinary, nullable=False),  # JPEG, without anything else that was in the file
    Column("small", LargeBinary, nullable=False),
    Column("deleted", Boolean, nullable=False),
    _of_mission(),
)

georeferences = Table(
    "georeferences",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("lat_deg", Float, nullable=False),
    Column("lon_deg", Float, nullable=False),
    Column("yaw_rad", Float, nullable=False),
    Column("height_m", Float, nullable=False),
    Column("sd_m", Float, nullable=False),
    Column("points", JSON, nullable=False),  # of each: x_m, y_m, lat_deg, lon_deg
    Column("by", String(200), nullable=False),
    Column("changed_unix_s", Float, nullable=False),
    _of_mission(),
)

base_maps = Table(
    "base_maps",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("source", Text, nullable=False),  # a file's name, or a mission
    Column("grid", LargeBinary, nullable=False),  # robots.codec of TeamGrid
    Column("by", String(200), nullable=False),
    Column("changed_unix_s", Float, nullable=False),
    _of_mission(),
)

# those that were replaced or taken away: the last few, so that a change can be taken back
past_base_maps = Table(
    "past_base_maps",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("changed_unix_s", Float, primary_key=True),
    Column("source", Text, nullable=False),
    Column("grid", LargeBinary, nullable=False),
    Column("by", String(200), nullable=False),
    _of_mission(),
)

sectors = Table(
    "sectors",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("sector_id", String(36), primary_key=True),
    Column("name", String(60), nullable=False),
    Column("area_m", JSON, nullable=False),  # corners in the world frame
    Column("status", String(20), nullable=False),  # unassigned | under_way | searched | second_look
    Column("robots", JSON, nullable=False),
    Column("team", String(60), nullable=False),
    Column("note", Text, nullable=False),
    Column("period", Integer),
    Column("by", String(200), nullable=False),
    Column("created_unix_s", Float, nullable=False),
    Column("changed_unix_s", Float, nullable=False),
    Column("deleted", Boolean, nullable=False),
    Column("worksite", JSON(none_as_null=True)),  # db.worksites.WorksiteRecord
    _of_mission(),
)

periods = Table(
    "periods",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("commander", String(60), nullable=False),
    Column("objectives", Text, nullable=False),
    Column("begun_unix_s", Float, nullable=False),
    Column("ended_unix_s", Float),
    _of_mission(),
)
