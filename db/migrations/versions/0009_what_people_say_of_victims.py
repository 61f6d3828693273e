"""What people say about victims grows: triage, counts, team, place, which victim it really is."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("victims", sa.Column("said", sa.JSON(), nullable=False, server_default="{}"))
    victims = sa.table(
        "victims",
        *(sa.column(name) for name in ("mission_id", "victim_id", "status", "note", "by")),
        sa.column("said", sa.JSON()),
    )
    connection = op.get_bind()
    for row in connection.execute(sa.select(victims)).all():
        said = {"status": row.status, "note": row.note, "by": row.by}
        chosen = sa.and_(victims.c.mission_id == row.mission_id, victims.c.victim_id == row.victim_id)
        connection.execute(sa.update(victims).where(chosen).values(said=said))
    with op.batch_alter_table("victims") as table:
        table.alter_column("said", existing_type=sa.JSON(), server_default=None)
        table.drop_column("status")
        table.drop_column("note")
