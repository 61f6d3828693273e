"""Missions have a key that seals what is written into their tags."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("missions") as table:
        table.add_column(sa.Column("tag_key", sa.String(length=64), nullable=False, server_default=""))
    # what older versions kept has no window of a known side: it is read from the tags again
    op.execute("DELETE FROM tag_memories")
