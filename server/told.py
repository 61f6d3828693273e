"""What is written into the phone's page at a tag, so that its answer needs no second request."""

from __future__ import annotations

import time
from typing import Any, get_args

from fastapi import Request

from robots.routes.texts import Language, say
from robots.routes.words import metres
from server.api.common import Needs, access_of, all_missions
from server.api.routes import where_of
from server.errors import ApiError
from server.schemas.routes import WhereOut


async def told_at(request: Request, tag_id: str) -> dict[str, Any] | None:
    """Return what GET /api/v1/where/{tag_id} says to whoever asks for the page, None where it refuses."""
    language = _spoken(request.headers.get("accept-language", ""))
    mission = request.query_params.get("mission")
    try:
        access, missions = await access_of(request), await all_missions(request)
        by = await Needs("viewer")(request, access.actor_of(request))
        found = where_of(missions, by, tag_id, mission, language)
    except ApiError:
        return None
    words = _words_of(found, language)
    return {
        "language": language,
        "as_of_s": time.time(),
        "words": words,
        "where": found.model_dump(mode="json"),
    }


def _words_of(where: WhereOut, language: Language) -> dict[str, str]:
    """Return a place as it is said at the top of the phone's page; as wordsOf in where.js."""
    unsure = say(language, "place_unsure", far=metres(where.sd_m)) if where.sd_m > 1.0 else ""
    return {
        "title": say(language, "tag", tag=where.tag_id),
        "text": f"{where.text} {unsure}".rstrip(),
        "warning": say(language, f"tag_{where.state}") if where.notice else "",
    }


def _spoken(accepted: str) -> Language:
    """Return the first language of a browser's list that there are words in."""
    known: tuple[Language, ...] = get_args(Language)
    for name in accepted.lower().split(","):
        for language in known:
            if name.strip().startswith(language):
                return language
    return "en"
