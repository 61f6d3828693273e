"""Orders to robots, the methods they explore by, and the edges of the unknown they weigh."""

from __future__ import annotations

import time
from typing import Any
from uuid import uuid4

from fastapi import APIRouter

from db.records import OrderRecord
from robots.exploration.methods import KNOWN, unknown_method
from robots.orders import OrderKind
from server.api.common import ERRORS, READS, OneMission, Operator, TheChange
from server.errors import ApiError
from server.mission.mission import Mission
from server.mission.orders import order_value
from server.people.audit import AuditedRoute
from server.robot_value import frontiers_value
from server.schemas.orders import FrontiersOut, MethodsIn, MethodsOut, OrderIn, OrderOut, OrdersOut

router = APIRouter(tags=["orders"], responses=ERRORS, dependencies=READS, route_class=AuditedRoute)
_ROBOT = "/missions/{mission_id}/robots/{robot_id}"
_LISTED = 100


@router.get("/methods", summary="The names of all methods", operation_id="get_methods")
async def get_methods() -> MethodsOut:
    """Return the names by which methods are chosen."""
    return MethodsOut(**{name: sorted(names) for name, names in KNOWN.items()})


@router.patch(_ROBOT, summary="Change a robot's methods", operation_id="change_methods")
async def change_methods(
    robot_id: str, body: MethodsIn, mission: OneMission, by: Operator, change: TheChange
) -> OrderOut:
    """Order a robot to explore by other methods, from its next observation on."""
    mission.roster.get(robot_id)
    change.subject = robot_id
    chosen = {name: getattr(body, name) for name in KNOWN if getattr(body, name)}
    if not chosen:
        raise ApiError(422, "invalid", "Nothing is to be changed; name a method.")
    for name, value in chosen.items():
        wrong = unknown_method(name, value)
        if wrong is not None:
            raise ApiError(422, "unknown_method", f"{wrong}.", name)
    return await _issue(mission, _record(robot_id, "methods", by.name, **chosen))


@router.post(f"{_ROBOT}/orders", status_code=201, summary="Order a robot", operation_id="give_order")
async def give_order(
    robot_id: str, body: OrderIn, mission: OneMission, by: Operator, change: TheChange
) -> OrderOut:
    """Keep an order until the robot is heard next; it goes into the log with that observation."""
    mission.roster.get(robot_id)
    change.subject = robot_id
    return await _issue(
        mission,
        _record(robot_id, body.kind, by.name, x_m=body.x_m, y_m=body.y_m, area_m=corners(body.area_m)),
    )


@router.get(f"{_ROBOT}/orders", summary="Orders to a robot", operation_id="get_orders")
async def get_orders(robot_id: str, mission: OneMission) -> OrdersOut:
    """Return the latest orders to a robot and what has become of them, the latest first."""
    mission.roster.get(robot_id)
    orders = mission.orders.of(robot_id)[:_LISTED]
    return OrdersOut(orders=[OrderOut(**order_value(order)) for order in orders])


@router.get(f"{_ROBOT}/frontiers", summary="Where a robot could go", operation_id="get_frontiers")
async def get_frontiers(robot_id: str, mission: OneMission) -> FrontiersOut:
    """Return the edges of the unknown as the robot weighed them last, in the world frame."""
    value = frontiers_value(mission.roster.get(robot_id))
    return FrontiersOut.model_validate(value or {"robot_id": robot_id, "frontiers": []})


def corners(area: list[list[float]]) -> tuple[tuple[float, float], ...]:
    """Return an area of the wire as it is stored."""
    return tuple((x, y) for x, y in area)


def _record(robot_id: str, kind: OrderKind, by: str, **more: Any) -> OrderRecord:
    return OrderRecord(str(uuid4()), robot_id, kind, by, time.time(), **more)


async def _issue(mission: Mission, order: OrderRecord) -> OrderOut:
    return OrderOut(**order_value(await mission.orders.issue(order)))
