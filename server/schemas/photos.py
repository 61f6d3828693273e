"""Photos on the wire."""

from __future__ import annotations

from typing import Annotated, Self
from uuid import UUID

from pydantic import BaseModel, ConfigDict, Field, model_validator

from server.schemas.common import Metres, Name, Wire

UnixSeconds = Annotated[float, Field(ge=0.0, le=1e12)]


class PhotoQuery(BaseModel):
    """What a photo is of, in the address: exactly one of victim, note, tag or place."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    photo_id: UUID = Field(
        description="A UUID made by whoever sends it, so that sending twice does no harm.",
        examples=["5f0c2a7e-8f8e-4a52-9a53-0d5a6b1f4c11"],
    )
    victim_id: Name | None = Field(None, description="The victim it shows.", examples=["3"])
    annotation_id: UUID | None = Field(None, description="The note it belongs to.")
    tag_id: Name | None = Field(None, description="The tag it was taken at.", examples=["A-017"])
    x_m: Metres | None = Field(None, description="Or its place in the world frame.")
    y_m: Metres | None = None
    text: str = Field("", max_length=500, description="What it shows, in words.")
    taken_unix_s: UnixSeconds | None = Field(None, description="When it was taken, by the sender's clock.")

    @model_validator(mode="after")
    def _is_of_one_thing(self) -> Self:
        placed = self.x_m is not None and self.y_m is not None
        partly = (self.x_m is None) != (self.y_m is None)
        named = [self.victim_id, self.annotation_id, self.tag_id]
        if partly or placed + sum(name is not None for name in named) != 1:
            raise ValueError("say what it shows by one of victim_id, annotation_id, tag_id, or x_m and y_m")
        return self


class PhotoOut(Wire):
    """A photo, without its pictures."""

    photo_id: str
    width: int = Field(description="Of the picture as it is kept, in pixels.")
    height: int
    text: str
    victim_id: str | None
    annotation_id: str | None
    tag_id: str | None
    x_m: float | None
    y_m: float | None
    by: str
    taken_unix_s: float | None
    created_unix_s: float = Field(description="When it arrived.")
    address: str = Field(description="Where the picture is, at most 2048 pixels along its longer side.")
    thumbnail: str = Field(description="Where a small one is, at most 320 pixels.")


class PhotosOut(Wire):
    """All photos, oldest first."""

    photos: list[PhotoOut]
