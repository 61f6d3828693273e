"""Base maps that were replaced or taken away, so that a change can be taken back."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "past_base_maps",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("changed_unix_s", sa.Float(), nullable=False),
        sa.Column("source", sa.Text(), nullable=False),
        sa.Column("grid", sa.LargeBinary(), nullable=False),
        sa.Column("by", sa.String(200), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_past_base_maps_missions"),
        sa.PrimaryKeyConstraint("mission_id", "changed_unix_s", name="pk_past_base_maps"),
    )


def downgrade() -> None:
    op.drop_table("past_base_maps")
