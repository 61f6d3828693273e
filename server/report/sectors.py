"""Sectors, worksites with their markings, and operational periods in the report."""

from __future__ import annotations

from server.markings.worksites import worksite_markings
from server.report.drawing import Value
from server.report.html import Html, clock, facts, join, table, tag
from server.report.markings import sprayed
from server.report.story import Story

_STATUSES = {
    "unassigned": "nobody is on it",
    "under_way": "under way",
    "searched": "searched",
    "second_look": "needs a second look",
}
_FOUND = {"clear": "rapid clearance: clear", "deceased": "rapid clearance: deceased only"}


def sectors_part(story: Story) -> Html:
    """Return every sector with what is marked at its front, and the operational periods."""
    sectors = sorted(story.of_kind("sector"), key=lambda each: each["name"])
    periods = sorted(story.of_kind("period"), key=lambda each: each["number"])
    if not sectors and not periods:
        return Html("")
    rows = [
        (
            each["name"], f"{each['size_m2']:.0f} m²", _STATUSES[each["status"]],
            ", ".join([*each["robots"], *filter(None, [each["team"]])]), each["period"], each["note"],
            each["by"],
        )
        for each in sectors
    ]  # fmt: skip
    heads = ("Sector", "Size", "Status", "Searched by", "Period", "Note", "Changed by")
    told = [
        (
            each["number"], each["commander"], each["objectives"], clock(each["begun_unix_s"]),
            clock(each["ended_unix_s"]),
        )
        for each in periods
    ]  # fmt: skip
    return tag(
        "section",
        tag("h2", "Sectors and operational periods"),
        table(("Period", "Commander", "Objectives", "Begun", "Over"), told) if told else "",
        table(heads, rows) if rows else "",
        join(_worksite(each, story) for each in sectors if each.get("worksite")),
    )


def _worksite(sector: Value, story: Story) -> Html:
    worksite = sector["worksite"]
    visits = [
        (
            visit["team"], visit["level"] and f"ASR{visit['level']}", clock(visit["entered_unix_s"]),
            clock(visit["left_unix_s"]), _end(visit), visit["parts"],
        )
        for visit in worksite["visits"]
    ]  # fmt: skip
    marked = [
        *((f"structure: {each['risk']} risk", each["team"], clock(each["rated_unix_s"]))
          for each in worksite.get("ratings", ())),
        *((_FOUND[each["found"]], each["team"], clock(each["cleared_unix_s"]))
          for each in worksite.get("clearances", ())),
    ]  # fmt: skip
    return tag(
        "article",
        tag("h3", f"Worksite {worksite['worksite_id']}, sector {sector['name']}"),
        sprayed(worksite_markings(sector, story.of_kind("victim"))),
        facts((
            ("Hazards", worksite["hazards"]),
            ("Triage", worksite["triage"]),
            ("Work", "no more is needed" if worksite["is_complete"] else "not complete"),
        )),
        table(("Team", "Level", "Entered", "Left", "How", "Parts"), visits) if visits else "",
        table(("Marked", "By", "When"), marked) if marked else "",
        class_="victim",
    )  # fmt: skip


def _end(visit: Value) -> str:
    if visit["left_unix_s"] is None:
        return "is inside"
    return "searched all" if visit["is_finished"] else "left unfinished"
