"""Victims on the wire: measured by robots, judged by people."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field, model_validator

from db.victim_records import Triage, VictimStatus
from server.schemas.common import Covariance, Metres, Name, Wire

Count = Annotated[int, Field(ge=0, le=10_000)]


class StartWire(Wire):
    """What was found by START, step by step; null is not found out yet."""

    walks: bool | None = Field(None, description="Can walk.")
    breaths_per_min: Annotated[int, Field(ge=0, le=120)] | None = Field(
        None, description="0: does not breathe."
    )
    breathes_after_airway: bool | None = Field(None, description="Breathes once the airway is open.")
    pulse: bool | None = Field(None, description="Radial pulse, or capillaries refill within 2 s.")
    obeys: bool | None = Field(None, description="Follows simple commands.")


class PlaceWire(Wire):
    """A point in the world frame."""

    x_m: Metres
    y_m: Metres


class VictimOut(Wire):
    """A victim: measured by robots, judged by people."""

    victim_id: str
    x_m: float
    y_m: float
    covariance: Covariance
    confidence: float
    sightings: int
    robots: list[str]
    first_seen_s: float
    last_seen_s: float
    status: VictimStatus
    note: str
    team: str = Field(description="Whom it is assigned to.")
    live: int | None = Field(description="How many live are still there; null while nobody has said.")
    dead: int | None
    live_before: tuple[int, ...] = Field(description="Counts that stood there before, the oldest first.")
    dead_before: tuple[int, ...]
    start: StartWire
    triage: Triage = Field(description="By START from `start`; `deceased` only by what a person found.")
    place_m: tuple[float, float] | None = Field(description="Where a person put it, if one has.")
    merged_into: str | None = Field(description="The victim that it really is.")
    tag_id: str | None = Field(description="The tag it was reported at and moves with; null of others.")
    by: str = Field(description="Who said so last; empty while only robots have.")
    changed_unix_s: float | None


class VictimsOut(Wire):
    """All victims."""

    victims: list[VictimOut]


class VictimIn(Wire):
    """What a person says about a victim; what is left out stays as it is."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"status": "confirmed", "note": "answers when called"},
                {"live": 1, "dead": 0, "team": "AUS01", "start": {"walks": False, "breaths_per_min": 34}},
            ]
        }
    )

    status: VictimStatus | None = None
    note: str | None = Field(None, max_length=2000)
    team: str | None = Field(None, max_length=60)
    live: Count | None = None
    dead: Count | None = None
    start: StartWire | None = None
    place_m: PlaceWire | None = Field(None, description="null: where the robots measured it.")
    merged_into: Name | None = Field(None, description="null: it stands for itself.")

    @model_validator(mode="after")
    def _says_something(self) -> VictimIn:
        said = self.model_fields_set
        if not said:
            raise ValueError("say something: status, note, team, live, dead, start, place_m or merged_into")
        for name in ("status", "note", "team", "start"):
            if name in said and getattr(self, name) is None:
                raise ValueError(f"{name} cannot be null; leave it out to keep it")
        return self
