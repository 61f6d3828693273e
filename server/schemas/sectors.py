"""Sectors and operational periods on the wire."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from db.sectors import SectorStatus
from server.mission.sectors import signed_m2
from server.schemas.common import Corner, Name, Wire
from server.schemas.worksites import WorksiteWire

_SMALLEST_M2 = 0.25


class SectorIn(Wire):
    """A part of the ground to search."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"name": "B2", "area_m": [[0.0, 0.0], [8.0, 0.0], [8.0, 5.0], [0.0, 5.0]]},
                {
                    "name": "B3",
                    "area_m": [[8.0, 0.0], [16.0, 0.0], [16.0, 5.0]],
                    "status": "under_way",
                    "robots": ["r1"],
                    "team": "AUS01",
                    "worksite": {"worksite_id": "B-3", "hazards": "gas", "triage": "C"},
                },
            ]
        }
    )

    name: str = Field(min_length=1, max_length=60, description="What people call it.")
    area_m: list[Corner] = Field(min_length=3, max_length=500, description="Its corners, x and y of each.")
    status: SectorStatus = "unassigned"
    robots: list[Name] = Field(default_factory=list, max_length=100, description="The robots that search it.")
    team: str = Field("", max_length=60, description="The team of people that searches it.")
    note: str = Field("", max_length=2000)
    worksite: WorksiteWire | None = Field(
        None, description="What is marked at its front; left out: as it is; null: nothing."
    )

    @model_validator(mode="after")
    def _is_a_sector(self) -> Self:
        if abs(signed_m2(tuple((x, y) for x, y in self.area_m))) < _SMALLEST_M2:
            raise ValueError("area_m holds hardly any ground; draw its corners one after the other round it")
        if self.status == "unassigned" and (self.robots or self.team):
            raise ValueError("whoever is to search it makes it under_way, not unassigned")
        if self.status == "under_way" and not (self.robots or self.team):
            raise ValueError("say who searches it: robots, or a team of people")
        return self


class SectorOut(Wire):
    """A sector."""

    sector_id: str
    name: str
    area_m: list[list[float]]
    size_m2: float
    status: SectorStatus
    robots: list[str]
    team: str
    note: str
    worksite: WorksiteWire | None
    period: int | None = Field(description="The operational period in which it was assigned or judged last.")
    by: str
    created_unix_s: float
    changed_unix_s: float


class SectorsOut(Wire):
    """All sectors, the oldest first."""

    sectors: list[SectorOut]


class ExploreOut(Wire):
    """The orders that came of it."""

    order_ids: list[str]


class PeriodIn(Wire):
    """The next operational period."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"commander": "Ada", "objectives": "Clear the north wing."}]}
    )

    commander: Annotated[str, Field(min_length=1, max_length=60, description="Who commands in it.")]
    objectives: str = Field("", max_length=2000)


class PeriodOut(Wire):
    """An operational period."""

    number: int
    commander: str
    objectives: str
    begun_unix_s: float
    ended_unix_s: float | None = Field(description="null: it goes on.")


class PeriodsOut(Wire):
    """All operational periods, the first first."""

    periods: list[PeriodOut]
