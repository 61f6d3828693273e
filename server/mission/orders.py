"""Orders to robots: issued here, delivered in an observation, and done or failed as the agent says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import structlog

from db.errors import DatabaseError
from db.records import OrderRecord, Severity
from db.store import Store
from robots.orders import PLACED, Methods, RobotOrder
from robots.types import AgentUpdate, Observation
from server.board import Board
from server.errors import ApiError
from server.mission.events import Events
from server.robot import Robot

MAX_WAITING = 16  # for one robot
_SHOWN = 5  # of one robot on the board
_DONE_KINDS = {"return", "go_to", "explore_here", "drop_tag", "methods"}  # whose end is news

log = structlog.get_logger()


class Orders:
    """The orders of a mission, by id in the order in which they were issued.

    The server puts them into the next observation of a robot that it leads, before that is saved; a robot
    with its agent on board is told in the reply and puts them into its next observation itself. So they are
    in the log, and a replay decides the same.
    """

    def __init__(self, store: Store, mission_id: str, board: Board, events: Events) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._events = events
        self._orders: dict[str, OrderRecord] = {}

    async def restore(self) -> None:
        """Bring the orders back from the database."""
        for order in await self._store.orders.orders_of(self._mission_id):
            self._orders[order.order_id] = order
        for robot_id in {order.robot_id for order in self._orders.values()}:
            self._show(robot_id)

    def of(self, robot_id: str) -> list[OrderRecord]:
        """Return the orders to a robot, the latest first."""
        return [order for order in reversed(self._orders.values()) if order.robot_id == robot_id]

    async def issue(self, order: OrderRecord) -> OrderRecord:
        """Keep an order until its robot is heard next, and return it.

        Raises:
            ApiError: too many orders wait for that robot already.
            DatabaseError: it could not be saved, and is not given.
        """
        waiting = [known for known in self.of(order.robot_id) if known.state == "issued"]
        if len(waiting) >= MAX_WAITING:
            text = f"{len(waiting)} orders wait for {order.robot_id} already; it has to be heard first."
            raise ApiError(409, "too_many_orders", text)
        await self._store.orders.record_order(self._mission_id, order)
        self._hold(order)
        await self._events.tell("order", f"{order.by} orders {words(order)}.", order.robot_id)
        return order

    def waiting(self, robot: Robot) -> tuple[RobotOrder, ...]:
        """Return the orders that a robot has not been told yet, with places in its map frame."""
        issued = [order for order in self._orders.values() if order.state == "issued"]
        told = (_for_robot(order, robot) for order in issued if order.robot_id == robot.robot_id)
        return tuple(order for order in told if order is not None)

    def attach(self, robot: Robot, fresh: Sequence[Observation]) -> list[Observation]:
        """Return a batch with the orders that wait in its last observation, where the server leads."""
        waiting = self.waiting(robot) if robot.record.agent == "server" else ()
        if not waiting:
            return list(fresh)
        last = fresh[-1]
        return [*fresh[:-1], replace(last, orders=(*last.orders, *waiting)[:MAX_WAITING])]

    async def delivered(self, fresh: Sequence[Observation]) -> None:
        """Note which orders are in the log now."""
        for observation in fresh:
            for told in observation.orders:
                order = self._orders.get(told.order_id)
                if order is not None and order.state == "issued":
                    await self._advance(replace(order, state="delivered"))

    async def report(self, update: AgentUpdate) -> None:
        """Take over what an agent says about its orders."""
        for report in update.orders:
            order = self._orders.get(report.order_id)
            if order is None or order.state == report.state:
                continue
            order = replace(order, state=report.state, text=report.text)
            await self._advance(order)
            if report.state == "failed" or order.kind in _DONE_KINDS:
                severity: Severity = "warning" if report.state == "failed" else "info"
                what = words(order).partition(" ")[2]
                text = f"{order.robot_id}, ordered {what}: {report.state}, {report.text}."
                await self._events.tell(f"order_{report.state}", text, order.robot_id, severity)

    async def _advance(self, order: OrderRecord) -> None:
        """Keep a new state; the log holds the order itself, so a database that is full loses little."""
        self._hold(order)
        try:
            await self._store.orders.record_order(self._mission_id, order)
        except DatabaseError as error:
            log.error("an order could not be saved", order_id=order.order_id, reason=str(error))

    def _hold(self, order: OrderRecord) -> None:
        self._orders[order.order_id] = order
        self._show(order.robot_id)

    def _show(self, robot_id: str) -> None:
        shown = [order_value(order) for order in self.of(robot_id)[:_SHOWN]]
        self._board.publish({f"orders/{robot_id}": {"robot_id": robot_id, "orders": shown}})


def order_value(order: OrderRecord) -> dict[str, Any]:
    """Return an order as it stands on the board and in replies."""
    return {**asdict(order), "area_m": [list(corner) for corner in order.area_m]}


_WORDS = {
    "return": "to return",
    "hold": "to stand still",
    "resume": "to explore on",
    "go_to": "to go to",
    "explore_here": "to explore round",
    "drop_tag": "to drop a tag",
}


def words(order: OrderRecord) -> str:
    """Return an order in words, as in "r1 to return"."""
    if order.kind == "methods":
        named = {name: getattr(order, name) for name in Methods.__slots__ if getattr(order, name)}
        return f"{order.robot_id} to take {', '.join(f'{name} {value}' for name, value in named.items())}"
    place = "" if order.x_m is None or order.y_m is None else f" ({order.x_m:.1f}, {order.y_m:.1f})"
    return f"{order.robot_id} {_WORDS[order.kind]}{place}"


def _for_robot(order: OrderRecord, robot: Robot) -> RobotOrder | None:
    """Return an order as its robot takes it; None while nobody knows where a place lies in its map."""
    place: tuple[float, float] | None = None
    area: tuple[tuple[float, float], ...] = ()
    if order.kind in PLACED and order.x_m is not None and order.y_m is not None:
        world_from_map = robot.world_from_map()
        if world_from_map is None:
            return None
        map_from_world = world_from_map.inverse()
        place = map_from_world.transform_point(order.x_m, order.y_m)
        area = tuple(map_from_world.transform_point(*corner) for corner in order.area_m)
    methods = Methods(order.explore, order.coordinate, order.communication)
    return RobotOrder(order.order_id, order.kind, order.by, place, methods, area)
