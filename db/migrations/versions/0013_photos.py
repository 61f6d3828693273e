"""Photos of victims, notes, tags and places."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "photos",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("photo_id", sa.String(36), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("width", sa.Integer(), nullable=False),
        sa.Column("height", sa.Integer(), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("victim_id", sa.String(100)),
        sa.Column("annotation_id", sa.String(36)),
        sa.Column("tag_id", sa.String(100)),
        sa.Column("x_m", sa.Float()),
        sa.Column("y_m", sa.Float()),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("taken_unix_s", sa.Float()),
        sa.Column("created_unix_s", sa.Float(), nullable=False),
        sa.Column("whole", sa.LargeBinary(), nullable=False),
        sa.Column("small", sa.LargeBinary(), nullable=False),
        sa.Column("deleted", sa.Boolean(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_photos_missions"),
        sa.PrimaryKeyConstraint("mission_id", "photo_id", name="pk_photos"),
    )
