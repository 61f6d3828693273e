"""Where a mission lies on the Earth."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter, Query

from db.mission_records import GeoreferenceRecord
from server.api.common import ERRORS, READS, OneMission, Operator, TheChange
from server.errors import ApiError
from server.geo.georeference import ControlPoint, GeometryError, Georeference, solve
from server.geo.mgrs import from_mgrs, to_mgrs
from server.geo.utm import to_utm
from server.people.audit import AuditedRoute
from server.schemas.common import Metres
from server.schemas.georeference import EarthPlaceIn, EarthPlaceOut, GeoreferenceIn, GeoreferenceOut

router = APIRouter(
    prefix="/missions/{mission_id}/georeference",
    tags=["georeference"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("", summary="Where the mission lies", operation_id="get_georeference")
async def get_georeference(mission: OneMission) -> GeoreferenceOut:
    """Return where the world frame lies on the Earth, and by which control points."""
    mission.georeferences.get()
    return GeoreferenceOut.model_validate(mission.georeferences.value(), strict=False)


@router.put("", summary="Say where the mission lies", operation_id="put_georeference")
async def put_georeference(
    body: GeoreferenceIn, mission: OneMission, by: Operator, change: TheChange
) -> GeoreferenceOut:
    """Place the world frame on the Earth, by origin and heading or by points known on both.

    Points are refused that are too near to each other, or whose distances do not fit.
    """
    change.before = mission.georeferences.value()
    points: tuple[tuple[float, float, float, float], ...] = ()
    if body.origin is not None and body.yaw_rad is not None:
        found = Georeference(*_place(body.origin, "origin"), body.yaw_rad, body.height_m)
    else:
        known = body.control_points or []
        points = tuple(
            (point.x_m, point.y_m, *_place(point, f"control_points.{k}")) for k, point in enumerate(known)
        )
        try:
            found = solve([ControlPoint(*point) for point in points], body.height_m)
        except GeometryError as error:
            message = str(error)
            raise ApiError(
                422, "bad_geometry", f"{message[0].upper()}{message[1:]}.", "control_points"
            ) from error
    record = GeoreferenceRecord(
        found.lat_deg, found.lon_deg, found.yaw_rad, found.height_m, found.sd_m, points, by.name, time.time()
    )
    await mission.georeferences.set(record, by.name)
    change.after = mission.georeferences.value()
    return GeoreferenceOut.model_validate(change.after, strict=False)


@router.delete("", status_code=204, summary="Forget where it lies", operation_id="delete_georeference")
async def delete_georeference(mission: OneMission, by: Operator, change: TheChange) -> None:
    """Take the mission off the Earth; that can be taken back."""
    mission.georeferences.get()
    change.before = mission.georeferences.value()
    await mission.georeferences.set(None, by.name)


@router.get("/place", summary="A place on the Earth", operation_id="get_earth_place")
async def get_earth_place(
    mission: OneMission, x_m: Annotated[Metres, Query()], y_m: Annotated[Metres, Query()]
) -> EarthPlaceOut:
    """Return latitude, longitude and grid reference of a place of the world frame."""
    lat, lon = mission.georeferences.get().to_earth(x_m, y_m)
    try:
        utm, grid = str(to_utm(lat, lon)), to_mgrs(lat, lon)
    except ValueError:
        return EarthPlaceOut(lat_deg=lat, lon_deg=lon, utm=None, grid=None)
    return EarthPlaceOut(lat_deg=lat, lon_deg=lon, utm=utm, grid=grid)


def _place(place: EarthPlaceIn, field: str) -> tuple[float, float]:
    if place.lat_deg is not None and place.lon_deg is not None:
        return place.lat_deg, place.lon_deg
    try:
        return from_mgrs(place.grid or "")
    except ValueError as error:
        raise ApiError(422, "no_grid_reference", f"{error}.", f"{field}.grid") from error
