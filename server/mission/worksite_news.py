"""What has changed at a worksite, in words for everybody."""

from __future__ import annotations

from collections.abc import Iterator

from db.worksites import WorksiteRecord

_FOUND = {"clear": "it is clear", "deceased": "only deceased are left"}


def worksite_news(before: WorksiteRecord | None, after: WorksiteRecord | None) -> Iterator[str]:
    """Yield a sentence without its end for everything that is new in ``after``."""
    if after is None:
        return
    name = f"worksite {after.worksite_id}"
    known = () if before is None else before.visits
    for k, visit in enumerate(after.visits):
        if k >= len(known):
            yield f"{visit.team} went into {name}"
        if visit.left_unix_s is not None and (k >= len(known) or known[k].left_unix_s is None):
            yield f"{visit.team} left {name}, {'all is searched' if visit.is_finished else 'not finished'}"
    for rating in after.ratings[0 if before is None else len(before.ratings) :]:
        yield f"{rating.team} found the structure of {name} a {rating.risk} risk"
    for clearance in after.clearances[0 if before is None else len(before.clearances) :]:
        yield f"{clearance.team} searched {name}: {_FOUND[clearance.found]}"
    if after.triage is not None and (before is None or before.triage != after.triage):
        yield f"W{name[1:]} is triaged {after.triage}"
    if after.is_complete != (before is not None and before.is_complete):
        yield f"W{name[1:]} needs {'no more work' if after.is_complete else 'work again'}"
