"""Alerts may be about robots, tags, victims and people, not about nodes alone; and EVACUATE."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

_ID = sa.String(length=100)


def upgrade() -> None:
    with op.batch_alter_table("alerts") as table:
        table.alter_column("tag_id", existing_type=_ID, nullable=True)
        table.alter_column("robot_id", existing_type=_ID, nullable=True)
        table.add_column(sa.Column("victim_id", _ID))
    op.create_table(
        "evacuations",
        sa.Column("mission_id", _ID, nullable=False),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.Column("since_unix_s", sa.Float(), nullable=False),
        sa.Column("acknowledged", sa.JSON(), nullable=False),
        sa.PrimaryKeyConstraint("mission_id", name=op.f("pk_evacuations")),
        sa.ForeignKeyConstraint(
            ["mission_id"], ["missions.mission_id"], name=op.f("fk_evacuations_missions")
        ),
    )
