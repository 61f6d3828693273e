"""Operators give orders to robots."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "orders",
        sa.Column("mission_id", sa.String(length=100), nullable=False),
        sa.Column("order_id", sa.String(length=36), nullable=False),
        sa.Column("robot_id", sa.String(length=100), nullable=False),
        sa.Column("kind", sa.String(length=20), nullable=False),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.Column("issued_unix_s", sa.Float(), nullable=False),
        sa.Column("x_m", sa.Float()),
        sa.Column("y_m", sa.Float()),
        sa.Column("explore", sa.String(length=40), nullable=False),
        sa.Column("coordinate", sa.String(length=40), nullable=False),
        sa.Column("communication", sa.String(length=40), nullable=False),
        sa.Column("state", sa.String(length=10), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("mission_id", "order_id", name="pk_orders"),
        sa.ForeignKeyConstraint(
            ["mission_id", "robot_id"],
            ["robots.mission_id", "robots.robot_id"],
            name="fk_orders_mission_id",
        ),
    )
