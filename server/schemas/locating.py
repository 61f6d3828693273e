"""Where somebody is who hears nodes, on the wire."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from server.schemas.common import Covariance, Metres, Wire

TagId = Annotated[str, Field(min_length=1, max_length=100)]


class HeardIn(Wire):
    """One reading of a node: how strong its signal was, or how far off it is by its own measure."""

    node_id: TagId = Field(description="Its tag id.")
    rssi_dbm: float | None = Field(None, ge=-150.0, le=50.0)
    range_m: float | None = Field(None, ge=0.0, le=1000.0)

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if (self.rssi_dbm is None) == (self.range_m is None):
            raise ValueError("give rssi_dbm or range_m, one of them")
        return self


class LocateIn(Wire):
    """What a device hears where it stands, and where it was for certain."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "heard": [
                        {"node_id": "N3", "rssi_dbm": -31.5},
                        {"node_id": "N7", "rssi_dbm": -38.0},
                        {"node_id": "N8", "range_m": 7.2},
                    ]
                }
            ]
        }
    )

    heard: list[HeardIn] = Field(
        min_length=1, max_length=500, description="All readings made here; several of a node are averaged."
    )
    last_tag: TagId | None = Field(None, description="The tag touched last; with steps.")
    steps: int | None = Field(None, ge=0, le=100_000, description="Steps made since.")

    @model_validator(mode="after")
    def _belong_together(self) -> Self:
        if (self.last_tag is None) != (self.steps is None):
            raise ValueError("last_tag and steps belong together: give both or none")
        return self


class PlaceOut(Wire):
    """A place that fits what is heard."""

    x_m: Metres
    y_m: Metres
    covariance: Covariance
    share: float = Field(description="How likely it is among those that fit, 0 to 1.")
    is_hollow: bool = Field(description="One is somewhere round this middle, but not in it.")
    right_to_m: float = Field(description="Two standard deviations along the longest axis.")
    tag_id: str = Field(description="The tag next to it.")
    distance_m: float = Field(description="From that tag.")
    bearing_deg: float = Field(description="From that tag, as of routes.")


class RingOut(Wire):
    """All that one node tells: how far off it is, in any direction."""

    node_id: str
    x_m: Metres
    y_m: Metres
    range_m: float
    sd_m: float


class LocatedOut(Wire):
    """Where one is: one place, several that fit, the most likely first, or a ring round one node."""

    places: list[PlaceOut]
    ring: RingOut | None
    fits: bool = Field(description="What is heard agrees; otherwise the covariances were widened.")
    left_out: list[str] = Field(description="Nodes not used: those that contradict all others or themselves.")
    unknown: list[str] = Field(description="Nodes whose place is not known.")
    text: str = Field(description="In words that need no map.")
