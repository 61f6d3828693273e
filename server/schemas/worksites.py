"""Worksites on the wire: what is marked at the front of a sector."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from db.worksites import (
    ClearanceRecord,
    Entry,
    Found,
    RatingRecord,
    Risk,
    VisitRecord,
    WorksiteRecord,
    WorksiteTriage,
)
from server.schemas.common import Wire

WORKSITE_ID = r"^([A-Z]-[0-9]{1,4}[a-z]?|[A-Z]{3}[0-9]{2}-[0-9]{4})$"
UnixSeconds = Annotated[float, Field(ge=0.0, le=1e11, allow_inf_nan=False)]


class VisitWire(Wire):
    """A team inside."""

    team: str = Field(min_length=1, max_length=20, description="Its id, as INSARAG's AUS01.")
    level: Annotated[int, Field(ge=1, le=5)] | None = Field(
        None, description="INSARAG's assessment, search and rescue level; null: none of them."
    )
    entered_unix_s: UnixSeconds
    left_unix_s: UnixSeconds | None = Field(None, description="null: the team is inside.")
    is_finished: bool = Field(False, description="All was searched that it went in for.")
    parts: str = Field("", max_length=40, description="Floors and quadrants that were done.")

    @model_validator(mode="after")
    def _ends_as_it_can(self) -> Self:
        if self.left_unix_s is None and self.is_finished:
            raise ValueError("say when the team left, or is_finished false while it is inside")
        if self.left_unix_s is not None and self.left_unix_s < self.entered_unix_s:
            raise ValueError("a team cannot leave before it has entered")
        return self


class RatingWire(Wire):
    """How safe a team found the structure, as FEMA's box says it."""

    team: str = Field(min_length=1, max_length=20)
    risk: Risk
    entry: Entry | None = Field(None, description="Where the safest entry is, facing the front.")
    rated_unix_s: UnixSeconds


class ClearanceWire(Wire):
    """INSARAG's rapid clearance: a team searched all of it (ASR5)."""

    team: str = Field(min_length=1, max_length=20)
    found: Found = Field(description="clear: nobody is left; deceased: only deceased are.")
    cleared_unix_s: UnixSeconds


class WorksiteWire(Wire):
    """What is marked at the front of a sector."""

    worksite_id: str = Field(
        pattern=WORKSITE_ID,
        description="C-5 or C-12b: marked by INSARAG's edition of 2020; AUS01-0102: by that of 2027.",
    )
    hazards: str = Field("", max_length=120, description="In plain words.")
    triage: WorksiteTriage | None = Field(
        None,
        description="INSARAG: A live confirmed, under 12 h; B live confirmed, 12 h or more; C live possible;"
        " D only deceased.",
    )
    is_complete: bool = Field(False, description="No more work is needed.")
    visits: list[VisitWire] = Field(
        default_factory=list, max_length=50, description="Who came, the first first; none is ever erased."
    )

    ratings: list[RatingWire] = Field(
        default_factory=list, max_length=20, description="The newest is drawn; none is ever erased."
    )
    clearances: list[ClearanceWire] = Field(
        default_factory=list, max_length=10, description="All are drawn; none is ever erased."
    )

    @model_validator(mode="after")
    def _is_complete_only_when_all_are_out(self) -> Self:
        if self.is_complete and any(visit.left_unix_s is None for visit in self.visits):
            raise ValueError("is_complete cannot be true while a team is inside; say first that it left")
        return self

    def record(self) -> WorksiteRecord:
        """Return it as it is stored."""
        visits = tuple(VisitRecord(**visit.model_dump()) for visit in self.visits)
        ratings = tuple(RatingRecord(**rating.model_dump()) for rating in self.ratings)
        clearances = tuple(ClearanceRecord(**clearance.model_dump()) for clearance in self.clearances)
        return WorksiteRecord(
            self.worksite_id, self.hazards, self.triage, self.is_complete, visits, ratings, clearances
        )
