"""Alerts, MAYDAY and EVACUATE on the wire."""

from __future__ import annotations

import re
from typing import Any

from pydantic import ConfigDict, Field, model_validator

from db.records import AlertKind, Severity
from server.schemas.common import NAME_PATTERN, Name, Wire


class AlertOut(Wire):
    """Something that people have to know."""

    alert_id: str
    kind: AlertKind = Field(
        description="Of nodes `hot`, `tilted` (knocked over), `pressure` (it changed); of robots `lost`,"
        " `stuck`, `slipping`, `battery`, `magazine`, `agent`; `tag` (the map contradicts itself there),"
        " `victim`, `mayday`."
    )
    text: str
    severity: Severity
    raised_unix_s: float
    robot_id: str | None = Field(description="The robot that it is about, or that saw it.")
    tag_id: str | None = Field(description="The tag or node that it is about, or where it is.")
    victim_id: str | None
    over_unix_s: float | None = Field(description="Since when it is over; null while it goes on.")
    acknowledged_by: str = Field(description="Who has taken note; empty while nobody has.")
    acknowledged_unix_s: float | None


class AlertsOut(Wire):
    """Open alerts, the earliest first."""

    alerts: list[AlertOut]


def told_where(said: Any) -> Any:
    """Return a call for help with what is no tag's id as words: nobody is refused help for that."""
    if not isinstance(said, dict) or said.get("tag_id") is None:
        return said
    tag_id = said["tag_id"]
    if isinstance(tag_id, str) and len(tag_id) <= 64 and re.match(NAME_PATTERN, tag_id):
        return said
    words = [f"the tag there reads “{str(tag_id)[:64]}”", *filter(None, [said.get("text")])]
    return said | {"tag_id": None, "text": "; ".join(map(str, words))[:500]}


class MaydayIn(Wire):
    """Somebody needs help."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"text": "low on air, second floor", "tag_id": "A4"}, {}]}
    )

    text: str = Field("", max_length=500, description="What is wrong, if there is time to say.")
    tag_id: Name | None = Field(None, description="The last tag that was read.")

    @model_validator(mode="before")
    @classmethod
    def _is_let_through(cls, said: Any) -> Any:
        return told_where(said)


class AcknowledgementOut(Wire):
    """Who has heard EVACUATE."""

    name: str
    unix_s: float


class EvacuationOut(Wire):
    """EVACUATE as it stands."""

    ordered: bool
    by: str | None
    since_unix_s: float | None
    acknowledged: list[AcknowledgementOut]
