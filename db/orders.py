"""Orders of operators to robots."""

from __future__ import annotations

from dataclasses import asdict, fields

from sqlalchemy import Connection, select

from db.engine import Database, upsert
from db.records import OrderRecord
from db.tables import orders


class OrderStore:
    """Orders of a mission by id; on the disk once written."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_order(self, mission_id: str, record: OrderRecord) -> None:
        """Keep an order as it is now; what was known of it before is replaced."""
        row = {"mission_id": mission_id, **asdict(record)}
        await self._database.write(lambda c: upsert(c, orders, [row]), durable=True)

    async def orders_of(self, mission_id: str) -> list[OrderRecord]:
        """Return the orders of a mission, the earliest first."""
        columns = [orders.c[item.name] for item in fields(OrderRecord)]

        def query(connection: Connection) -> list[OrderRecord]:
            chosen = select(*columns).where(orders.c.mission_id == mission_id)
            rows = connection.execute(chosen.order_by(orders.c.issued_unix_s, orders.c.order_id))
            return [OrderRecord.of(dict(row._mapping)) for row in rows]

        return await self._database.read(query)
