"""Making a mission's report from the database alone."""

from __future__ import annotations

import asyncio

from db.records import EventRecord, MissionRecord
from db.store import Store
from server.history.past import Past
from server.report.page import report_page
from server.report.photos import gather
from server.report.story import pictures_of, tell
from server.sharing import alert_value

_PAGE = 1000


async def make_report(store: Store, mission: MissionRecord) -> str:
    """Return the report of a mission as it stands now, one HTML file.

    Raises:
        DatabaseError: the database cannot be read.
    """
    past = Past(store, mission.mission_id)
    story = await asyncio.to_thread(tell, [chunk async for chunk in past.chunks()])
    for alert in await store.alerts.alerts_of(mission.mission_id):  # who took note of one that is over
        story.alerts[alert.alert_id, alert.raised_unix_s] = alert_value(alert)
    pictures = {}
    for version in pictures_of(story):
        png = await past.picture(version)
        if png is not None:
            pictures[version] = png
    events = await _all_events(store, mission.mission_id)
    album = await gather(store, mission.mission_id)
    return await asyncio.to_thread(report_page, mission, story, pictures, events, album)


async def _all_events(store: Store, mission_id: str) -> list[EventRecord]:
    found: list[EventRecord] = []
    while True:
        page = await store.findings.events_after(mission_id, found[-1].event_id if found else 0, _PAGE)
        found += page
        if len(page) < _PAGE:
            return found
