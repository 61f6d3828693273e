"""Where somebody is who hears radio nodes: range-only localisation for phones and other devices."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from robots.routes.texts import Language
from server.api.common import ERRORS, READS, OneMission
from server.schemas.locating import LocatedOut, LocateIn

router = APIRouter(
    prefix="/missions/{mission_id}/where", tags=["routes"], responses=ERRORS, dependencies=READS
)
Speaks = Annotated[Language, Query(description="The language of the words.")]


@router.post("", summary="Where am I, by what I hear?", operation_id="locate_by_radio")
async def locate_by_radio(said: LocateIn, mission: OneMission, language: Speaks = "en") -> LocatedOut:
    """Return where one is who hears nodes that robots have mapped, and how well that is known.

    Two nodes often leave two places that mirror each other, one node a ring. Walls of the plan, and the tag
    touched last with the steps made since, rule out what they can.
    """
    return await mission.locating.locate(said, language)
