"""MAYDAY: somebody calls for help, and calls again when that changes or nobody comes."""

from __future__ import annotations

from db.records import AlertRecord
from server.mission.alerts import Alerts


def is_repeated(alerts: Alerts, by: str, text: str, tag_id: str | None) -> bool:
    """Say whether such a call stands there already, unacknowledged, and says as much."""
    known = alerts.get("mayday", by)
    if known is None or known.over_unix_s is not None or known.acknowledged_unix_s is not None:
        return False
    return tag_id in (None, known.tag_id) and text in known.text


async def call_for_help(
    alerts: Alerts, by: str, text: str, tag_id: str | None, ago_min: int = 0
) -> AlertRecord:
    """Raise MAYDAY, or raise it anew: told as an event, and to be acknowledged once more.

    Where one goes on, the tag it named before stays in the words: two people may share a log-in.
    """
    known = alerts.get("mayday", by)
    before = known.tag_id if known is not None and known.over_unix_s is None else None
    where = f" near tag {tag_id}" if tag_id else ""
    earlier = f", before that near tag {before}" if before not in (None, tag_id) else ""
    late = f", called {ago_min} min ago without signal" if ago_min else ""
    said = f"MAYDAY from {by}{where}{earlier}{late}{f': {text}' if text else ''}."
    return await alerts.raise_(
        "mayday", by, said, "alarm", event="mayday", tag_id=tag_id or before, is_anew=True
    )
