"""Active nodes and alerts on the wire."""

from __future__ import annotations

from pydantic import Field

from db.records import AlertKind, Severity
from server.schemas.common import Wire


class NodeOut(Wire):
    """What an active node measured last; null where it has no such sensor."""

    tag_id: str
    temperature_c: float | None
    pressure_hpa: float | None
    tilt_rad: float | None = Field(description="How far its antenna leans from upright.")
    heard_unix_s: float
    robot_id: str = Field(description="The robot that heard it.")


class AlertOut(Wire):
    """An alert about a node."""

    alert_id: str
    tag_id: str
    kind: AlertKind = Field(description="`hot`, `tilted` (knocked over), or `pressure` (it changed).")
    text: str
    robot_id: str = Field(description="The robot that heard the node.")
    severity: Severity
    raised_unix_s: float
    over_unix_s: float | None = Field(description="Since when it is over; null while it goes on.")
    acknowledged_by: str = Field(description="Who has taken note; empty while nobody has.")
    acknowledged_unix_s: float | None


class AlertsOut(Wire):
    """Open alerts, the earliest first."""

    alerts: list[AlertOut]
