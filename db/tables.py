"""The tables, in SQLAlchemy Core: SI units and radians, units in the names, times of day in Unix seconds."""

from sqlalchemy import (
    JSON,
    Boolean,
    Column,
    Float,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    String,
    Table,
    Text,
)

from db.schema import ID, NUMBER, metadata


def _of_mission() -> ForeignKeyConstraint:
    return ForeignKeyConstraint(["mission_id"], ["missions.mission_id"])


def _of_robot() -> ForeignKeyConstraint:
    return ForeignKeyConstraint(["mission_id", "robot_id"], ["robots.mission_id", "robots.robot_id"])


missions = Table(
    "missions",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("name", Text, nullable=False),
    Column("state", String(20), nullable=False),  # draft | running | paused | closed | archived
    Column("created_unix_s", Float, nullable=False),
    Column("stopped_all", Boolean, nullable=False),
    Column("tag_key", String(64), nullable=False, server_default=""),
    Column("state_by", String(200), nullable=False, server_default=""),
    Column("state_unix_s", Float, nullable=False, server_default="0"),
    Column("started_unix_s", Float),
    Column("ran_s", Float, nullable=False, server_default="0"),
)

robots = Table(
    "robots",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("robot_id", ID, primary_key=True),
    Column("agent", String(20), nullable=False),  # server | onboard
    Column("silence_after_s", Float, nullable=False),
    Column("silence_policy", String(20), nullable=False),
    Column("start_x_m", Float),
    Column("start_y_m", Float),
    Column("start_yaw_rad", Float),
    Column("start_sd_m", Float),
    Column("start_sd_rad", Float),
    Column("config", LargeBinary, nullable=False),  # robots.codec of AgentConfig
    Column("stopped", Boolean, nullable=False),
    Column("registered_unix_s", Float, nullable=False),
    _of_mission(),
)

observations = Table(
    "observations",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("robot_id", ID, primary_key=True),
    Column("seq", NUMBER, primary_key=True, autoincrement=False),
    Column("stamp_s", Float, nullable=False),
    Column("received_unix_s", Float, nullable=False),
    Column("body", LargeBinary, nullable=False),  # robots.codec of Observation
    Column("fault", Text),  # why the agent could not take it; an empty one takes its place
    _of_robot(),
)

agent_snapshots = Table(
    "agent_snapshots",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("robot_id", ID, primary_key=True),
    Column("seq", NUMBER, nullable=False),  # of the last observation that is in it
    Column("body", LargeBinary, nullable=False),
    Column("updates", JSON, nullable=False),  # the latest in short, for robots that ask again
    _of_robot(),
)

tags = Table(
    "tags",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("tag_id", ID, primary_key=True),
    Column("x_m", Float, nullable=False),
    Column("y_m", Float, nullable=False),
    Column("var_x", Float, nullable=False),
    Column("var_xy", Float, nullable=False),
    Column("var_y", Float, nullable=False),
    Column("sightings", Integer, nullable=False),
    Column("robots", JSON, nullable=False),
    Column("state", String(20), nullable=False, server_default="sound"),  # sound | moved | cloned | doubtful
    Column("notice", Text, nullable=False, server_default=""),
    _of_mission(),
)

tag_memories = Table(
    "tag_memories",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("tag_id", ID, primary_key=True),
    Column("version", Integer, primary_key=True, autoincrement=False),
    Column("memory", LargeBinary, nullable=False),
    Column("written_unix_s", Float, nullable=False),
    Column("by", String(200), nullable=False),
    _of_mission(),
)

node_readings = Table(
    "node_readings",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("tag_id", ID, primary_key=True),
    Column("temperature_c", Float),
    Column("pressure_hpa", Float),
    Column("tilt_rad", Float),
    Column("usual_pressure_hpa", Float),
    Column("heard_unix_s", Float, nullable=False),
    Column("robot_id", ID, nullable=False),
    _of_mission(),
)

alerts = Table(
    "alerts",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("alert_id", String(120), primary_key=True),  # kind:subject
    Column("kind", String(20), nullable=False),
    Column("text", Text, nullable=False),
    Column("severity", String(10), nullable=False),
    Column("raised_unix_s", Float, nullable=False),
    Column("robot_id", ID),
    Column("tag_id", ID),
    Column("victim_id", ID),
    Column("over_unix_s", Float),
    Column("acknowledged_by", String(200), nullable=False),
    Column("acknowledged_unix_s", Float),
    _of_mission(),
)

evacuations = Table(
    "evacuations",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("by", String(200), nullable=False),
    Column("since_unix_s", Float, nullable=False),
    Column("acknowledged", JSON, nullable=False),  # pairs of a name and a time
    _of_mission(),
)

graph_vertices = Table(
    "graph_vertices",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("robot_id", ID, primary_key=True),
    Column("kind", String(10), primary_key=True),  # pose | tag
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("tag_id", ID),
    Column("x_m", Float, nullable=False),  # in the robot's map frame
    Column("y_m", Float, nullable=False),
    Column("yaw_rad", Float),
    Column("stamp_s", Float),
    Column("imu_yaw_rad", Float),
    _of_robot(),
)

graph_edges = Table(
    "graph_edges",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("robot_id", ID, primary_key=True),
    # displacement (pose to pose) | sighting (pose to tag) | loop (pose to pose) | meeting (pose to robot)
    Column("kind", String(12), primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("from_number", Integer, nullable=False),
    Column("to_number", Integer),
    Column("x_m", Float, nullable=False),  # in the frame of the first pose
    Column("y_m", Float, nullable=False),
    Column("yaw_rad", Float),
    Column("covariance", JSON, nullable=False),  # rows of a 3 x 3 or 2 x 2 matrix, one after the other
    Column("other_robot_id", ID),  # who was met,
    Column("stamp_s", Float),  # and when
    _of_robot(),
)

victims = Table(
    "victims",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("victim_id", ID, primary_key=True),
    Column("x_m", Float, nullable=False),
    Column("y_m", Float, nullable=False),
    Column("var_x", Float, nullable=False),
    Column("var_xy", Float, nullable=False),
    Column("var_y", Float, nullable=False),
    Column("confidence", Float, nullable=False),
    Column("sightings", Integer, nullable=False),
    Column("robots", JSON, nullable=False),
    Column("first_seen_s", Float, nullable=False),
    Column("last_seen_s", Float, nullable=False),
    Column("said", JSON, nullable=False),  # db.victim_records.SaidRecord
    Column("by", String(200), nullable=False),  # who said so last; empty while only robots have
    _of_mission(),
)

annotations = Table(
    "annotations",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("annotation_id", String(36), primary_key=True),
    Column("kind", String(20), nullable=False),
    Column("text", Text, nullable=False),
    Column("x_m", Float),
    Column("y_m", Float),
    Column("tag_id", ID),
    Column("by", String(200), nullable=False),
    Column("created_unix_s", Float, nullable=False),
    Column("changed_unix_s", Float, nullable=False),
    Column("deleted", Boolean, nullable=False),
    Column("area_m", JSON, nullable=False, server_default="[]"),
    _of_mission(),
)

reports = Table(
    "reports",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("report_id", String(36), primary_key=True),
    Column("kind", String(20), nullable=False),
    Column("by", String(200), nullable=False),
    Column("made_unix_s", Float, nullable=False),
    Column("received_unix_s", Float, nullable=False),
    Column("phone_unix_s", Float, nullable=False),
    Column("offset_s", Float),
    Column("body", JSON, nullable=False),
    Column("outcome", Text, nullable=False),
    _of_mission(),
)

orders = Table(
    "orders",
    metadata,
    Column("mission_id", ID, primary_key=True),
    Column("order_id", String(36), primary_key=True),
    Column("robot_id", ID, nullable=False),
    Column("kind", String(20), nullable=False),
    Column("by", String(200), nullable=False),
    Column("issued_unix_s", Float, nullable=False),
    Column("x_m", Float),  # in the world frame
    Column("y_m", Float),
    Column("explore", String(40), nullable=False),
    Column("coordinate", String(40), nullable=False),
    Column("communication", String(40), nullable=False),
    Column("state", String(10), nullable=False),  # issued | delivered | done | failed
    Column("text", Text, nullable=False),
    Column("area_m", JSON, nullable=False, server_default="[]"),
    _of_robot(),
)

events = Table(
    "events",
    metadata,
    Column("event_id", NUMBER, primary_key=True, autoincrement=True),
    Column("mission_id", ID, nullable=False),
    Column("unix_s", Float, nullable=False),
    Column("kind", String(40), nullable=False),
    Column("text", Text, nullable=False),
    Column("robot_id", ID),
    Column("severity", String(10), nullable=False),
    _of_mission(),
    Index("ix_events_mission_id", "mission_id", "event_id"),
)
