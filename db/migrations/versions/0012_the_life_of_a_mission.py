"""Missions have states with who and when, leave something behind, and how they get on is kept."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("missions", sa.Column("state_by", sa.String(200), nullable=False, server_default=""))
    op.add_column("missions", sa.Column("state_unix_s", sa.Float(), nullable=False, server_default="0"))
    op.add_column("missions", sa.Column("started_unix_s", sa.Float()))
    op.add_column("missions", sa.Column("ran_s", sa.Float(), nullable=False, server_default="0"))
    op.execute("UPDATE missions SET state_unix_s = created_unix_s, started_unix_s = created_unix_s")
    mission = sa.ForeignKeyConstraint
    op.create_table(
        "endings",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("ended_unix_s", sa.Float(), nullable=False),
        sa.Column("board", sa.JSON(), nullable=False),
        sa.Column("grid", sa.LargeBinary()),
        mission(["mission_id"], ["missions.mission_id"], name="fk_endings_missions"),
        sa.PrimaryKeyConstraint("mission_id", name="pk_endings"),
    )
    op.create_table(
        "progress",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("unix_s", sa.Float(), nullable=False),
        sa.Column("clock_s", sa.Float(), nullable=False),
        sa.Column("explored_m2", sa.Float(), nullable=False),
        sa.Column("tags", sa.Integer(), nullable=False),
        sa.Column("victims", sa.Integer(), nullable=False),
        mission(["mission_id"], ["missions.mission_id"], name="fk_progress_missions"),
        sa.PrimaryKeyConstraint("mission_id", "unix_s", name="pk_progress"),
    )
