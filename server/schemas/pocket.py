"""A mission in one file, on the wire."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from db.records import AnnotationKind, TagState
from db.victim_records import Triage, VictimStatus
from server.schemas.alerts import EvacuationOut
from server.schemas.common import Wire
from server.schemas.routes import PlaceKindOut

End = tuple[str, int]


class PocketTagOut(Wire):
    """A tag, to the centimetre."""

    tag_id: str
    x_m: float
    y_m: float
    sd_m: float
    state: TagState
    notice: str
    place_kind: PlaceKindOut


class PocketVictimOut(Wire):
    """A victim, and the tags in sight of it."""

    victim_id: str
    x_m: float
    y_m: float
    sd_m: float
    status: VictimStatus
    confidence: float
    live: int | None
    dead: int | None
    triage: Triage
    note: str
    merged_into: str | None
    by: str
    ends: list[End] = Field(description="A tag in sight, and centimetres from there.")


class PocketNoteOut(Wire):
    """A note, and the tags in sight of it."""

    annotation_id: str
    kind: AnnotationKind
    text: str
    x_m: float | None = Field(description="Its place, also of an area or at a tag; null while not known.")
    y_m: float | None
    tag_id: str | None
    area_m: list[list[float]]
    by: str
    changed_unix_s: float
    ends: list[End]


class PocketBaseOut(Wire):
    """Where the mission's first robot started."""

    x_m: float
    y_m: float
    tag_id: str | None = Field(description="The tag that lies there.")
    ends: list[End] = Field(description="A tag in sight, and centimetres from there.")


class PocketRadioOut(Wire):
    """The radio of the mission's nodes: log-distance path loss."""

    power_at_1m_dbm: float
    path_loss_exponent: float
    distances_m: list[float] = Field(description="Where the deviation of the shadowing is known.")
    sds_db: list[float] = Field(description="That deviation, linear in between.")
    fading_sd_db: float = Field(description="Of every reading.")
    reach_m: float
    gain_sd_db: float = Field(description="Of phones among each other.")
    exponent_sd: float = Field(description="Of buildings among each other, as a share of the exponent.")
    wall_db: float = Field(description="What a wall takes.")


class PocketPlanOut(Wire):
    """The plan as a picture."""

    version: int
    width: int
    height: int
    resolution_m: float
    origin_m: tuple[float, float] = Field(description="World coordinates of the lower left corner.")
    png: str = Field(description="Base64: 0 unknown (transparent), 1 free, 2 occupied; the top row first.")


class PocketOut(Wire):
    """A mission in one file."""

    mission_id: str
    mission_name: str
    state: str
    created_unix_s: float
    evacuation: EvacuationOut | None
    radio: PocketRadioOut
    x_axis_deg: float | None = Field(description="True bearing of the plan's x axis; null while not known.")
    parts: dict[str, str] = Field(
        description="Names of `ground` (`tags`, `ways`) and `plan` (`map`), of their content."
    )
    map: PocketPlanOut | None = Field(None, description="Missing, not null, where it was left out.")
    tags: list[PocketTagOut] = Field([], description="Missing where they were left out, as are the ways.")
    ways: list[tuple[int, int, int, list[int], int, int, int]] = Field(
        [],
        description="Numbers of two tags, the length in cm, the points between, x and y of each in cm, by how"
        " much more it counts for being narrow, its narrowest width, 0 where not known, in cm, and how long"
        " it was to somebody who walked it, 0 where a robot drove it, in cm.",
    )
    base: PocketBaseOut | None = Field(description="Where the first robot started; null while none has.")
    victims: list[PocketVictimOut]
    notes: list[PocketNoteOut]
    left_out: dict[str, Any] = Field(description="How many tags, victims and notes had no room.")
