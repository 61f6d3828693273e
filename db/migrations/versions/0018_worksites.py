"""What is marked at the front of a sector that is a worksite."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("sectors", sa.Column("worksite", sa.JSON()))
