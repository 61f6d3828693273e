"""Reports from the field on the wire."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import ConfigDict, Field, model_validator

from db.records import AnnotationKind
from db.reports import ReportKind
from server.schemas.alerts import told_where
from server.schemas.common import Name, Seconds, Wire
from server.schemas.victims import Count, StartWire

_NEEDS: dict[ReportKind, tuple[str, ...]] = {
    "note": ("note", "tag_id"),
    "victim": ("tag_id",),
    "mayday": (),
    "heard": ("since_unix_s",),
    "at": ("tag_id",),
}
_MAY: dict[ReportKind, tuple[str, ...]] = {
    "note": ("text",),
    "victim": ("text", "live", "dead", "start"),
    "mayday": ("text", "tag_id"),
    "heard": (),
    "at": ("from_tag", "after_s", "steps_m"),
}
_WHAT = ("note", "text", "tag_id", "live", "dead", "start", "since_unix_s", "from_tag", "after_s", "steps_m")
_CLOCKS = {"phone_unix_s": 1790000000.0, "offset_s": 3.5, "sent_phone_unix_s": 1790000060.0}


class ReportIn(Wire):
    """What somebody in the field has to say; sent again as often as it takes to get through."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "kind": "note",
                    "note": "hazard",
                    "text": "gas",
                    "tag_id": "A4",
                    "made_by": "ann",
                    **_CLOCKS,
                },
                {"kind": "victim", "tag_id": "A4", "live": 1, "dead": 0, "start": {"walks": True}, **_CLOCKS},
                {"kind": "mayday", "tag_id": "A4", **_CLOCKS},
                {"kind": "at", "tag_id": "A4", **_CLOCKS},
            ]
        }
    )

    kind: ReportKind = Field(
        description="`note` at a tag; `victim` at a tag; `mayday`; `heard`: EVACUATE; `at`: I am at this tag."
    )
    made_by: str = Field("", max_length=60, description="Who was logged in on the phone when it was made.")
    is_carried: bool = Field(False, description="It was made on another phone, which handed it over.")
    phone_unix_s: Seconds = Field(description="The phone's clock when it was made.")
    offset_s: Seconds | None = Field(
        None, description="By how much the phone knew then that its clock was slow; null: it did not know."
    )
    sent_phone_unix_s: Seconds = Field(description="The phone's clock as this is sent.")
    note: AnnotationKind | None = None
    text: str = Field("", max_length=2000)
    tag_id: Name | None = Field(None, description="The last tag that was read.")
    live: Annotated[Count | None, Field(description="How many live.")] = None
    dead: Annotated[Count | None, Field(description="How many dead.")] = None
    start: StartWire | None = Field(None, description="What was found by START.")
    since_unix_s: Seconds | None = Field(None, description="`since_unix_s` of the order that was heard.")

    from_tag: Name | None = Field(
        None,
        description="The tag that this phone read before this one: its owner walked from there, or, where"
        " that is too far for the time, both cannot be where the map says.",
    )
    after_s: Annotated[float | None, Field(ge=0, le=3600, description="How long before, s.")] = None
    steps_m: Annotated[
        float | None, Field(ge=0, le=10_000, description="How far it was by the phone's own count of steps.")
    ] = None

    @model_validator(mode="before")
    @classmethod
    def _is_let_through(cls, said: Any) -> Any:
        return told_where(said) if isinstance(said, dict) and said.get("kind") == "mayday" else said

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Self:
        needed, also = _NEEDS[self.kind], _MAY[self.kind]
        missing = [name for name in needed if getattr(self, name) is None]
        if missing:
            raise ValueError(f"a report of the kind {self.kind} needs {' and '.join(missing)}")
        if (self.from_tag is None) != (self.after_s is None):
            raise ValueError("from_tag and after_s go together")
        if self.steps_m is not None and self.from_tag is None:
            raise ValueError("steps_m says how far it was from from_tag: name that too")
        other = [name for name in _WHAT if name in self.model_fields_set and name not in (*needed, *also)]
        other = [name for name in other if getattr(self, name) not in (None, "")]
        if other:
            raise ValueError(f"a report of the kind {self.kind} has no {' and '.join(other)}")
        return self


class ReportOut(Wire):
    """A report, and what became of it."""

    report_id: str
    kind: ReportKind
    by: str = Field(description="Who made it, and who sent it if that was another.")
    made_unix_s: float = Field(description="By the server's clock, as far as that can be told.")
    received_unix_s: float
    phone_unix_s: float = Field(description="The phone's clock when it was made.")
    offset_s: float | None = Field(description="By how much the phone knew that its clock was slow.")
    body: dict[str, Any] = Field(description="What it says.")
    outcome: str = Field(description="What became of it, in words.")


class ReportsOut(Wire):
    """Reports, the newest first."""

    reports: list[ReportOut]
