"""Sectors, operational periods, and orders to explore an area."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "sectors",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("sector_id", sa.String(36), nullable=False),
        sa.Column("name", sa.String(60), nullable=False),
        sa.Column("area_m", sa.JSON(), nullable=False),
        sa.Column("status", sa.String(20), nullable=False),
        sa.Column("robots", sa.JSON(), nullable=False),
        sa.Column("team", sa.String(60), nullable=False),
        sa.Column("note", sa.Text(), nullable=False),
        sa.Column("period", sa.Integer()),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("created_unix_s", sa.Float(), nullable=False),
        sa.Column("changed_unix_s", sa.Float(), nullable=False),
        sa.Column("deleted", sa.Boolean(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_sectors_missions"),
        sa.PrimaryKeyConstraint("mission_id", "sector_id", name="pk_sectors"),
    )
    op.create_table(
        "periods",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False, autoincrement=False),
        sa.Column("commander", sa.String(60), nullable=False),
        sa.Column("objectives", sa.Text(), nullable=False),
        sa.Column("begun_unix_s", sa.Float(), nullable=False),
        sa.Column("ended_unix_s", sa.Float()),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_periods_missions"),
        sa.PrimaryKeyConstraint("mission_id", "number", name="pk_periods"),
    )
    op.add_column("orders", sa.Column("area_m", sa.JSON(), nullable=False, server_default="[]"))
