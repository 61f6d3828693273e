"""Reports from the field are kept by the id that the phone gave them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "reports",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("report_id", sa.String(36), nullable=False),
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("made_unix_s", sa.Float(), nullable=False),
        sa.Column("received_unix_s", sa.Float(), nullable=False),
        sa.Column("phone_unix_s", sa.Float(), nullable=False),
        sa.Column("offset_s", sa.Float()),
        sa.Column("body", sa.JSON(), nullable=False),
        sa.Column("outcome", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("mission_id", "report_id", name="pk_reports"),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_reports_missions"),
    )
