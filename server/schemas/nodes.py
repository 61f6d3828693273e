"""Active nodes on the wire."""

from __future__ import annotations

from pydantic import Field

from server.schemas.common import Wire


class NodeOut(Wire):
    """What an active node measured last; null where it has no such sensor."""

    tag_id: str
    temperature_c: float | None
    pressure_hpa: float | None
    tilt_rad: float | None = Field(description="How far its antenna leans from upright.")
    heard_unix_s: float
    temperature_c_per_min: float | None = Field(None, description="How it goes; null until that is known.")
    pressure_hpa_per_min: float | None = Field(None, description="How it goes; null until that is known.")
    robot_id: str = Field(description="The robot that heard it.")
