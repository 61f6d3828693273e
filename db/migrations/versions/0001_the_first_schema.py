"""The first schema."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "missions",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("state", sa.String(length=20), nullable=False),
        sa.Column("created_unix_s", sa.Float(), nullable=False),
        sa.Column("stopped_all", sa.Boolean(), nullable=False),
        sa.PrimaryKeyConstraint("mission_id", name=op.f("pk_missions")),
    )
    op.create_table(
        "annotations",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("annotation_id", sa.String(length=36), nullable=False),
        sa.Column("kind", sa.String(length=20), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("x_m", sa.Float(), nullable=True),
        sa.Column("y_m", sa.Float(), nullable=True),
        sa.Column("tag_id", sa.String(length=100), nullable=True),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.Column("created_unix_s", sa.Float(), nullable=False),
        sa.Column("changed_unix_s", sa.Float(), nullable=False),
        sa.Column("deleted", sa.Boolean(), nullable=False),
        sa.ForeignKeyConstraint(
            ["mission_id"], ["missions.mission_id"], name=op.f("fk_annotations_missions")
        ),
        sa.PrimaryKeyConstraint("mission_id", "annotation_id", name=op.f("pk_annotations")),
    )
    op.create_table(
        "events",
        sa.Column(
            "event_id",
            sa.BigInteger().with_variant(sa.Integer(), "sqlite"),
            autoincrement=True,
            nullable=False,
        ),
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("unix_s", sa.Float(), nullable=False),
        sa.Column("kind", sa.String(length=40), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=True),
        sa.Column("severity", sa.String(length=10), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name=op.f("fk_events_missions")),
        sa.PrimaryKeyConstraint("event_id", name=op.f("pk_events")),
    )
    op.create_index("ix_events_mission_id", "events", ["mission_id", "event_id"], unique=False)
    op.create_table(
        "robots",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column("agent", sa.String(length=20), nullable=False),
        sa.Column("silence_after_s", sa.Float(), nullable=False),
        sa.Column("silence_policy", sa.String(length=20), nullable=False),
        sa.Column("start_x_m", sa.Float(), nullable=True),
        sa.Column("start_y_m", sa.Float(), nullable=True),
        sa.Column("start_yaw_rad", sa.Float(), nullable=True),
        sa.Column("start_sd_m", sa.Float(), nullable=True),
        sa.Column("start_sd_rad", sa.Float(), nullable=True),
        sa.Column("config", sa.LargeBinary(), nullable=False),
        sa.Column("stopped", sa.Boolean(), nullable=False),
        sa.Column("registered_unix_s", sa.Float(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name=op.f("fk_robots_missions")),
        sa.PrimaryKeyConstraint("mission_id", "robot_id", name=op.f("pk_robots")),
    )
    op.create_table(
        "tag_memories",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("tag_id", sa.String(length=100), nullable=False),
        sa.Column("version", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("memory", sa.LargeBinary(), nullable=False),
        sa.Column("written_unix_s", sa.Float(), nullable=False),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.ForeignKeyConstraint(
            ["mission_id"], ["missions.mission_id"], name=op.f("fk_tag_memories_missions")
        ),
        sa.PrimaryKeyConstraint("mission_id", "tag_id", "version", name=op.f("pk_tag_memories")),
    )
    op.create_table(
        "tags",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("tag_id", sa.String(length=100), nullable=False),
        sa.Column("x_m", sa.Float(), nullable=False),
        sa.Column("y_m", sa.Float(), nullable=False),
        sa.Column("var_x", sa.Float(), nullable=False),
        sa.Column("var_xy", sa.Float(), nullable=False),
        sa.Column("var_y", sa.Float(), nullable=False),
        sa.Column("sightings", sa.Integer(), nullable=False),
        sa.Column("robots", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name=op.f("fk_tags_missions")),
        sa.PrimaryKeyConstraint("mission_id", "tag_id", name=op.f("pk_tags")),
    )
    op.create_table(
        "victims",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("victim_id", sa.String(length=100), nullable=False),
        sa.Column("x_m", sa.Float(), nullable=False),
        sa.Column("y_m", sa.Float(), nullable=False),
        sa.Column("var_x", sa.Float(), nullable=False),
        sa.Column("var_xy", sa.Float(), nullable=False),
        sa.Column("var_y", sa.Float(), nullable=False),
        sa.Column("confidence", sa.Float(), nullable=False),
        sa.Column("sightings", sa.Integer(), nullable=False),
        sa.Column("robots", sa.JSON(), nullable=False),
        sa.Column("first_seen_s", sa.Float(), nullable=False),
        sa.Column("last_seen_s", sa.Float(), nullable=False),
        sa.Column("status", sa.String(length=20), nullable=False),
        sa.Column("note", sa.Text(), nullable=False),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name=op.f("fk_victims_missions")),
        sa.PrimaryKeyConstraint("mission_id", "victim_id", name=op.f("pk_victims")),
    )
    op.create_table(
        "agent_snapshots",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column("seq", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("body", sa.LargeBinary(), nullable=False),
        sa.Column("updates", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(
            ["mission_id", "robot_id"],
            ["robots.mission_id", "robots.robot_id"],
            name=op.f("fk_agent_snapshots_robots"),
        ),
        sa.PrimaryKeyConstraint("mission_id", "robot_id", name=op.f("pk_agent_snapshots")),
    )
    op.create_table(
        "graph_edges",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column("kind", sa.String(length=10), nullable=False),
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("from_number", sa.Integer(), nullable=False),
        sa.Column("to_number", sa.Integer(), nullable=False),
        sa.Column("x_m", sa.Float(), nullable=False),
        sa.Column("y_m", sa.Float(), nullable=False),
        sa.Column("yaw_rad", sa.Float(), nullable=True),
        sa.Column("covariance", sa.JSON(), nullable=False),
        sa.ForeignKeyConstraint(
            ["mission_id", "robot_id"],
            ["robots.mission_id", "robots.robot_id"],
            name=op.f("fk_graph_edges_robots"),
        ),
        sa.PrimaryKeyConstraint("mission_id", "robot_id", "kind", "number", name=op.f("pk_graph_edges")),
    )
    op.create_table(
        "graph_vertices",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column("kind", sa.String(length=10), nullable=False),
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("tag_id", sa.String(length=100), nullable=True),
        sa.Column("x_m", sa.Float(), nullable=False),
        sa.Column("y_m", sa.Float(), nullable=False),
        sa.Column("yaw_rad", sa.Float(), nullable=True),
        sa.Column("stamp_s", sa.Float(), nullable=True),
        sa.Column("imu_yaw_rad", sa.Float(), nullable=True),
        sa.ForeignKeyConstraint(
            ["mission_id", "robot_id"],
            ["robots.mission_id", "robots.robot_id"],
            name=op.f("fk_graph_vertices_robots"),
        ),
        sa.PrimaryKeyConstraint("mission_id", "robot_id", "kind", "number", name=op.f("pk_graph_vertices")),
    )
    op.create_table(
        "observations",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column(
            "seq", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), autoincrement=False, nullable=False
        ),
        sa.Column("stamp_s", sa.Float(), nullable=False),
        sa.Column("received_unix_s", sa.Float(), nullable=False),
        sa.Column("body", sa.LargeBinary(), nullable=False),
        sa.Column("fault", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(
            ["mission_id", "robot_id"],
            ["robots.mission_id", "robots.robot_id"],
            name=op.f("fk_observations_robots"),
        ),
        sa.PrimaryKeyConstraint("mission_id", "robot_id", "seq", name=op.f("pk_observations")),
    )


def downgrade() -> None:
    op.drop_table("observations")
    op.drop_table("graph_vertices")
    op.drop_table("graph_edges")
    op.drop_table("agent_snapshots")
    op.drop_table("victims")
    op.drop_table("tags")
    op.drop_table("tag_memories")
    op.drop_table("robots")
    op.drop_index("ix_events_mission_id", table_name="events")
    op.drop_table("events")
    op.drop_table("annotations")
    op.drop_table("missions")
