"""What a mission showed at every moment is kept, to be looked at again."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from db.schema import ID, NUMBER

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "history_chunks",
        sa.Column("mission_id", ID, primary_key=True),
        sa.Column("number", sa.Integer(), primary_key=True, autoincrement=False),
        sa.Column("begins_unix_s", sa.Float(), nullable=False),
        sa.Column("ends_unix_s", sa.Float(), nullable=False),
        sa.Column("body", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"]),
    )
    op.create_table(
        "history_lines",
        sa.Column("mission_id", ID, primary_key=True),
        sa.Column("chunk", sa.Integer(), primary_key=True, autoincrement=False),
        sa.Column("line", sa.Integer(), primary_key=True, autoincrement=False),
        sa.Column("unix_s", sa.Float(), nullable=False),
        sa.Column("body", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"]),
    )
    op.create_table(
        "history_maps",
        sa.Column("mission_id", ID, primary_key=True),
        sa.Column("version", NUMBER, primary_key=True, autoincrement=False),
        sa.Column("png", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"]),
    )
