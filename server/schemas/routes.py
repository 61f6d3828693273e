"""Routes on the wire."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from db.records import TagState
from db.victim_records import VictimStatus
from robots.routes.place_kind import PlaceKind
from server.schemas.common import Wire

NorthKind = Annotated[
    Literal["true", "plan"],
    Field(
        description="From which north bearings are: true north by the mission's georeference, or the plan's,"
        " along x, where nobody has said how it lies on the Earth. A compass shows magnetic north, some"
        " degrees off true; by how much here is not known."
    ),
]


PlaceKindOut = Annotated[
    PlaceKind,
    Field(description="Of what kind the place is by the walls round it; empty where the map does not tell."),
]


class LegOut(Wire):
    """From one tag to the next."""

    from_tag: str
    to_tag: str
    distance_m: float
    bearing_deg: float = Field(description="Bearing at its start, 0 to 360, from `north`.")
    text: str
    points_m: list[list[float]] = Field(description="Where it bends, x and y of each point, ends included.")
    uncertain: bool = Field(description="Length and direction are but a guess.")
    walked: bool = Field(description="Somebody went there on foot; nobody knows just where.")
    width_m: float | None = Field(description="Of its narrowest passage, up to 4 m; null where not known.")
    hazards: list[str] = Field(description="What it passes.")


class LastOut(Wire):
    """The last piece, from the last tag to what is looked for."""

    from_tag: str
    distance_m: float
    bearing_deg: float
    text: str
    uncertain: bool = Field(description="What is looked for has to be searched for there.")
    sd_m: float = Field(description="Standard deviation of where it is, seen from the tag.")


class NeighbourOut(Wire):
    """A tag next to this one."""

    tag_id: str
    distance_m: float
    bearing_deg: float


class NearVictimOut(Wire):
    """A victim, as seen from a tag."""

    victim_id: str
    status: VictimStatus
    distance_m: float = Field(description="Along the route; straight where there is none.")
    reachable: bool = Field(description="A route leads there.")


class WhereOut(Wire):
    """Where a tag is, in words that need no map, and what is near it."""

    mission_id: str
    mission_name: str
    tag_id: str
    x_m: float
    y_m: float
    sd_m: float = Field(description="Standard deviation of its place.")
    state: TagState
    notice: str
    place_kind: PlaceKindOut
    text: str
    north: NorthKind
    neighbours: list[NeighbourOut]
    victims: list[NearVictimOut]


class TypedOut(Wire):
    """The tags that somebody may have meant."""

    tag_ids: list[str]
    trouble: Literal["", "mistyped", "unknown"] = Field(
        description="Where there is none: a character is wrong, or no mission has a tag of this number."
    )


class RouteOut(Wire):
    """A route for people: tags one after the other, along what robots drove and people walked."""

    from_tag: str
    to: str
    x_m: float
    y_m: float
    distance_m: float
    legs: list[LegOut]
    last: LastOut | None
    north: NorthKind
