"""Edges of a tag graph may be loops and meetings of robots."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("graph_edges") as table:
        table.alter_column("kind", type_=sa.String(length=12), existing_type=sa.String(length=10))
        table.alter_column("to_number", nullable=True, existing_type=sa.Integer())
        table.add_column(sa.Column("other_robot_id", sa.String(length=100), nullable=True))
        table.add_column(sa.Column("stamp_s", sa.Float(), nullable=True))
