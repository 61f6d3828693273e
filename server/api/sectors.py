"""Sectors and operational periods."""

from __future__ import annotations

import time
from dataclasses import asdict
from uuid import UUID, uuid4

from fastapi import APIRouter

from db.records import OrderRecord
from db.sectors import SectorRecord
from server.api.common import ERRORS, READS, Commander, OneMission, Operator, TheChange
from server.api.orders import corners
from server.errors import ApiError
from server.mission.sectors import middle_of, sector_value
from server.people.audit import AuditedRoute
from server.schemas.sectors import (
    ExploreOut,
    PeriodIn,
    PeriodOut,
    PeriodsOut,
    SectorIn,
    SectorOut,
    SectorsOut,
)

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["sectors"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.get("/sectors", summary="All sectors", operation_id="get_sectors")
async def get_sectors(mission: OneMission) -> SectorsOut:
    """Return every sector, the oldest first."""
    return SectorsOut(sectors=[SectorOut(**sector_value(sector)) for sector in mission.sectors.all()])


@router.put("/sectors/{sector_id}", summary="Draw or assign a sector", operation_id="put_sector")
async def put_sector(
    sector_id: UUID, body: SectorIn, mission: OneMission, by: Operator, change: TheChange
) -> SectorOut:
    """Write or replace a sector. The id is made by whoever writes it, so sending twice does no harm."""
    for robot_id in body.robots:
        if robot_id not in mission.roster.robots:
            text = f"There is no robot {robot_id!r} in this mission; name one that has joined."
            raise ApiError(422, "unknown_robot", text, "robots")
    change.before = mission.sectors.value(str(sector_id))
    worksite = body.worksite.record() if body.worksite else None
    if "worksite" not in body.model_fields_set and change.before is not None:
        worksite = mission.sectors.get(str(sector_id)).worksite
    now = time.time()
    record = SectorRecord(
        sector_id=str(sector_id),
        name=body.name,
        area_m=corners(body.area_m),
        status=body.status,
        robots=tuple(dict.fromkeys(body.robots)),
        team=body.team,
        note=body.note,
        period=None,
        by=by.name,
        created_unix_s=now,
        changed_unix_s=now,
        worksite=worksite,
    )
    change.after = sector_value(await mission.sectors.put(record))
    return SectorOut(**change.after)


@router.delete(
    "/sectors/{sector_id}", status_code=204, summary="Remove a sector", operation_id="delete_sector"
)
async def delete_sector(sector_id: UUID, mission: OneMission, by: Operator, change: TheChange) -> None:
    """Take a sector off the map; that can be taken back."""
    change.before = mission.sectors.value(str(sector_id))
    await mission.sectors.remove(str(sector_id))


@router.post(
    "/sectors/{sector_id}/explore",
    status_code=201,
    summary="Have its robots explore a sector",
    operation_id="explore_sector",
)
async def explore_sector(sector_id: UUID, mission: OneMission, by: Operator, change: TheChange) -> ExploreOut:
    """Order every robot that a sector is assigned to to drive there and explore what is unknown in it."""
    sector = mission.sectors.get(str(sector_id))
    change.subject = sector.name
    if not sector.robots:
        text = f"No robot is assigned to sector {sector.name}; assign one first."
        raise ApiError(409, "no_robots", text)
    x_m, y_m = middle_of(sector.area_m)
    given = []
    for robot_id in sector.robots:
        order = OrderRecord(
            str(uuid4()), robot_id, "explore_here", by.name, time.time(),
            x_m=round(x_m, 2), y_m=round(y_m, 2), area_m=sector.area_m,
        )  # fmt: skip
        given.append((await mission.orders.issue(order)).order_id)
    return ExploreOut(order_ids=given)


@router.get("/periods", summary="All operational periods", operation_id="get_periods")
async def get_periods(mission: OneMission) -> PeriodsOut:
    """Return every operational period, the first first."""
    return PeriodsOut(periods=[PeriodOut(**asdict(period)) for period in mission.sectors.periods()])


@router.post("/periods", status_code=201, summary="Begin the next period", operation_id="begin_period")
async def begin_period(body: PeriodIn, mission: OneMission, by: Commander, change: TheChange) -> PeriodOut:
    """Begin the next operational period; the one before ends with that."""
    period = await mission.sectors.begin_period(body.commander, body.objectives, by.name)
    change.subject = str(period.number)
    return PeriodOut(**asdict(period))


@router.post("/periods/end", summary="End the period", operation_id="end_period")
async def end_period(mission: OneMission, by: Commander, change: TheChange) -> PeriodOut:
    """End the operational period that goes on."""
    period = await mission.sectors.end_period(by.name)
    change.subject = str(period.number)
    return PeriodOut(**asdict(period))
