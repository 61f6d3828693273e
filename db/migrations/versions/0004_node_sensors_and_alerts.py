"""What active nodes measured last, and the alerts about them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "node_readings",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("tag_id", sa.String(length=100), nullable=False),
        sa.Column("temperature_c", sa.Float(), nullable=True),
        sa.Column("pressure_hpa", sa.Float(), nullable=True),
        sa.Column("tilt_rad", sa.Float(), nullable=True),
        sa.Column("usual_pressure_hpa", sa.Float(), nullable=True),
        sa.Column("heard_unix_s", sa.Float(), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_node_readings_missions"),
        sa.PrimaryKeyConstraint("mission_id", "tag_id", name="pk_node_readings"),
    )
    op.create_table(
        "alerts",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("alert_id", sa.String(length=120), nullable=False),
        sa.Column("tag_id", sa.String(length=100), nullable=False),
        sa.Column("kind", sa.String(length=20), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column("severity", sa.String(length=10), nullable=False),
        sa.Column("raised_unix_s", sa.Float(), nullable=False),
        sa.Column("over_unix_s", sa.Float(), nullable=True),
        sa.Column("acknowledged_by", sa.String(length=200), nullable=False),
        sa.Column("acknowledged_unix_s", sa.Float(), nullable=True),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_alerts_missions"),
        sa.PrimaryKeyConstraint("mission_id", "alert_id", name="pk_alerts"),
    )
