"""Worksites: sectors that are marked at their front with who came, what is dangerous and how far they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

WorksiteTriage = Literal["A", "B", "C", "D"]
Risk = Literal["low", "moderate", "high"]
Entry = Literal["left", "right", "above", "below"]
Found = Literal["clear", "deceased"]


@dataclass(frozen=True, slots=True)
class VisitRecord:
    """A team inside: ``level`` 1..5 of INSARAG's assessment, search and rescue; ``parts``: which were done.

    ``left_unix_s`` is None while the team is inside.
    """

    team: str
    level: int | None
    entered_unix_s: float
    left_unix_s: float | None = None
    is_finished: bool = False
    parts: str = ""

    def begins(self, other: VisitRecord) -> bool:
        """Say whether ``other`` is this visit, at most with its end."""
        same = (self.team, self.entered_unix_s) == (other.team, other.entered_unix_s)
        return self == other or (same and self.level in (None, other.level) and self.left_unix_s is None)


@dataclass(frozen=True, slots=True)
class RatingRecord:
    """How safe a team found the structure (FEMA); ``entry``: where the safest one is, facing the front."""

    team: str
    risk: Risk
    entry: Entry | None
    rated_unix_s: float


@dataclass(frozen=True, slots=True)
class ClearanceRecord:
    """A team searched all of it and found it clear, or only deceased left (INSARAG's rapid clearance)."""

    team: str
    found: Found
    cleared_unix_s: float


@dataclass(frozen=True, slots=True)
class WorksiteRecord:
    """What is said at a worksite's front; ``triage`` A..D is that of worksites (INSARAG), not of people.

    ``visits``, ``ratings`` and ``clearances``: the first first; they only grow.
    """

    worksite_id: str
    hazards: str
    triage: WorksiteTriage | None
    is_complete: bool
    visits: tuple[VisitRecord, ...]
    ratings: tuple[RatingRecord, ...] = ()
    clearances: tuple[ClearanceRecord, ...] = ()

    @classmethod
    def of(cls, value: dict[str, Any]) -> WorksiteRecord:
        """Return it of its plain values, as they are stored and go over the wire."""
        written = {
            "visits": tuple(VisitRecord(**each) for each in value["visits"]),
            "ratings": tuple(RatingRecord(**each) for each in value.get("ratings", ())),
            "clearances": tuple(ClearanceRecord(**each) for each in value.get("clearances", ())),
        }
        return cls(**{**value, **written})


_NOTHING = WorksiteRecord("", "", None, False, ())


def goes_on(before: WorksiteRecord | None, after: WorksiteRecord | None) -> bool:
    """Say whether all that stands in ``before`` stands in ``after``: lines of a marking are never erased."""
    old, new = before or _NOTHING, after or _NOTHING
    return (
        len(old.visits) <= len(new.visits)
        and all(a.begins(b) for a, b in zip(old.visits, new.visits, strict=False))
        and new.ratings[: len(old.ratings)] == old.ratings
        and new.clearances[: len(old.clearances)] == old.clearances
    )
