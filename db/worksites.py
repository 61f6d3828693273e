"""Worksites: sectors that are marked at their front with who came, what is dangerous and how far they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

WorksiteTriage = Literal["A", "B", "C", "D"]


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
class WorksiteRecord:
    """What is said at a worksite's front; ``triage`` A..D is that of worksites (INSARAG), not of people."""

    worksite_id: str
    hazards: str
    triage: WorksiteTriage | None
    is_complete: bool
    visits: tuple[VisitRecord, ...]

    @classmethod
    def of(cls, value: dict[str, Any]) -> WorksiteRecord:
        """Return it of its plain values, as they are stored and go over the wire."""
        return cls(**{**value, "visits": tuple(VisitRecord(**visit) for visit in value["visits"])})


def goes_on(before: WorksiteRecord | None, after: WorksiteRecord | None) -> bool:
    """Say whether every visit of ``before`` stands in ``after``: lines of a marking are never erased."""
    old = () if before is None else before.visits
    new = () if after is None else after.visits
    return len(old) <= len(new) and all(a.begins(b) for a, b in zip(old, new, strict=False))
