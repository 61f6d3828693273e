"""Base maps on the wire."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from server.base_map import MAX_YAML
from server.schemas.common import Metres, Name, Radians, Wire

Threshold = Annotated[float, Field(ge=0.0, le=1.0)]


class PlanQuery(BaseModel):
    """What a plan's picture lacks, in the address: the YAML beside it, or its numbers one by one."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    yaml: str | None = Field(None, max_length=MAX_YAML, description="The text of the map_server YAML file.")
    resolution_m: Annotated[float, Field(gt=0.0, le=10.0)] | None = Field(
        None, description="Metres per pixel.", examples=[0.05]
    )
    origin_x_m: Metres = Field(0.0, description="Where the picture's lower left corner lies.")
    origin_y_m: Metres = 0.0
    origin_yaw_rad: Radians = Field(0.0, description="How the picture is turned about it.")
    negate: bool = Field(False, description="Light is wall and dark is floor.")
    occupied_thresh: Threshold = Field(0.65, description="Darker than this is wall.")
    free_thresh: Threshold = Field(0.196, description="Lighter than this is floor.")
    source: str = Field("a floor plan", min_length=1, max_length=200, description="What people call it.")


class CopyIn(Wire):
    """Which mission's map to take."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"mission_id": "school-1"}]})

    mission_id: Name = Field(description="The mission whose best map is taken; its latest where it has none.")


class BaseMapOut(Wire):
    """The base map that is served as a picture, as the map is."""

    version: int
    width: int = Field(description="In cells.")
    height: int
    resolution_m: float
    origin_m: tuple[float, float] = Field(description="World coordinates of the lower left corner.")
    explored_m2: float = Field(description="Free ground on it.")
    png: str = Field(description="Address of the picture: 0 unknown (transparent), 1 free, 2 occupied.")
    source: str = Field(description="What people call it.")
    by: str
