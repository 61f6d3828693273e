"""The store: everything that is written or read, in methods named for what they are for."""

from __future__ import annotations

from pathlib import Path

from db.alerts import AlertStore
from db.engine import Database
from db.findings import FindingStore
from db.graphs import GraphStore
from db.history import HistoryStore
from db.log import LogStore
from db.missions import MissionStore
from db.nodes import NodeStore
from db.orders import OrderStore
from db.people import PeopleStore
from db.photos import PhotoStore
from db.places import PlaceStore
from db.reports import ReportStore
from db.sectors import SectorStore
from db.tags import TagStore


class Store:
    """One database, by subject: ``missions`` (and robots), ``log``, ``graphs``, ``tags``, ``nodes``, ..."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self.missions = MissionStore(database)
        self.log = LogStore(database)
        self.graphs = GraphStore(database)
        self.tags = TagStore(database)
        self.nodes = NodeStore(database)
        self.alerts = AlertStore(database)
        self.orders = OrderStore(database)
        self.findings = FindingStore(database)
        self.places = PlaceStore(database)
        self.sectors = SectorStore(database)
        self.photos = PhotoStore(database)
        self.people = PeopleStore(database)
        self.reports = ReportStore(database)
        self.history = HistoryStore(database)

    @classmethod
    async def open(cls, target: str | Path) -> Store:
        """Open or create the database; see ``Database.open``.

        Raises:
            DatabaseError: the database cannot be used; the message says why and what to do.
        """
        return cls(await Database.open(target))

    async def close(self) -> None:
        """Finish every accepted write and let go of the database."""
        await self._database.close()
