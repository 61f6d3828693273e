"""Where missions lie on the Earth, and maps that were there before them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "georeferences",
        sa.Column("mission_id", sa.String(100), nullable=False),
        *(
            sa.Column(name, sa.Float(), nullable=False)
            for name in ("lat_deg", "lon_deg", "yaw_rad", "height_m", "sd_m")
        ),
        sa.Column("points", sa.JSON(), nullable=False),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("changed_unix_s", sa.Float(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_georeferences_missions"),
        sa.PrimaryKeyConstraint("mission_id", name="pk_georeferences"),
    )
    op.create_table(
        "base_maps",
        sa.Column("mission_id", sa.String(100), nullable=False),
        sa.Column("source", sa.Text(), nullable=False),
        sa.Column("grid", sa.LargeBinary(), nullable=False),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("changed_unix_s", sa.Float(), nullable=False),
        sa.ForeignKeyConstraint(["mission_id"], ["missions.mission_id"], name="fk_base_maps_missions"),
        sa.PrimaryKeyConstraint("mission_id", name="pk_base_maps"),
    )
