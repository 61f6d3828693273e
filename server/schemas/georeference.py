"""Where a mission lies on the Earth, on the wire."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from server.schemas.common import Metres, Radians, Wire

Latitude = Annotated[float, Field(ge=-90.0, le=90.0, description="Degrees north, WGS 84.")]
Longitude = Annotated[float, Field(ge=-180.0, le=180.0, description="Degrees east, WGS 84.")]
Grid = Annotated[str, Field(max_length=30, description="Or its MGRS reference, as 32U PU 91607 34903.")]


class EarthPlaceIn(Wire):
    """A place on the Earth: by latitude and longitude, or by grid reference."""

    lat_deg: Latitude | None = None
    lon_deg: Longitude | None = None
    grid: Grid | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        by_numbers = self.lat_deg is not None and self.lon_deg is not None
        if by_numbers == (self.grid is not None) or (self.lat_deg is None) != (self.lon_deg is None):
            raise ValueError("give lat_deg and lon_deg, or grid")
        return self


class ControlPointIn(EarthPlaceIn):
    """A place that is known on the map, in the world frame, and on the Earth."""

    x_m: Metres
    y_m: Metres


class GeoreferenceIn(Wire):
    """Where the mission lies: its origin and heading, or points known on the map and on the Earth."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"origin": {"lat_deg": 48.137154, "lon_deg": 11.576124}, "yaw_rad": 1.5708},
                {"origin": {"grid": "32U PU 91607 34903"}, "yaw_rad": 0.0},
                {
                    "control_points": [
                        {"x_m": 0.0, "y_m": 0.0, "lat_deg": 48.13715, "lon_deg": 11.57612},
                        {"x_m": 40.0, "y_m": 0.0, "lat_deg": 48.13751, "lon_deg": 11.57612},
                    ]
                },
            ]
        }
    )

    origin: EarthPlaceIn | None = Field(None, description="Where the origin of the world frame lies.")
    yaw_rad: Radians | None = Field(
        None, description="How its x axis is turned from east to north: 0 points east, 1.5708 north."
    )
    control_points: list[ControlPointIn] | None = Field(None, min_length=1, max_length=100)
    height_m: Annotated[float, Field(ge=-1000.0, le=9000.0)] = Field(
        0.0, description="Of the floor over the ellipsoid; matters little."
    )

    @model_validator(mode="after")
    def _says_it_one_way(self) -> Self:
        if (self.origin is None) != (self.yaw_rad is None) or (self.origin is None) == (
            self.control_points is None
        ):
            raise ValueError("give origin and yaw_rad, or control_points")
        return self


class GeoreferenceOut(Wire):
    """Where a mission lies. (east, north) = R(yaw) (x, y) in the level plane at the origin."""

    lat_deg: float = Field(description="Of the origin of the world frame.")
    lon_deg: float
    yaw_rad: float
    height_m: float
    sd_m: float = Field(description="Root mean square residual of the control points; 0 without any.")
    points: list[tuple[float, float, float, float]] = Field(
        description="The control points: x_m, y_m, lat_deg, lon_deg of each."
    )
    by: str
    changed_unix_s: float


class EarthPlaceOut(Wire):
    """A place of the world frame on the Earth."""

    lat_deg: float
    lon_deg: float
    utm: str | None = Field(description="Zone and half, easting and northing; null near the poles.")
    grid: str | None = Field(description="The MGRS reference of its square metre; null near the poles.")
