"""Tags say whether they are where their sightings claim."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("tags") as table:
        table.add_column(sa.Column("state", sa.String(length=20), nullable=False, server_default="sound"))
        table.add_column(sa.Column("notice", sa.Text(), nullable=False, server_default=""))
