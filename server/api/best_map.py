"""The best map: asked for, watched on the stream (`best_map`), and fetched when it is ready."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Header, Response

from server.api.common import ERRORS, READS, OneMission, Operator
from server.api.maps import PNG, picture
from server.errors import ApiError
from server.people.audit import AuditedRoute
from server.schemas.best_map import BestMapOut, BestMapStateOut

router = APIRouter(
    prefix="/missions/{mission_id}",
    tags=["map"],
    responses=ERRORS,
    dependencies=READS,
    route_class=AuditedRoute,
)


@router.post("/best-map", status_code=202, summary="Ask for the best map", operation_id="make_best_map")
async def make_best_map(mission: OneMission, by: Operator) -> BestMapStateOut:
    """Have everything that robots recorded solved at once, with loops closed wherever they came by again.

    Takes seconds to minutes in a process of its own, while the live map goes on. Whoever asks meanwhile
    joins; where nothing was observed since the last one, that one is the answer.
    """
    mission.best_map.ask()
    return BestMapStateOut.model_validate(mission.best_map.value(), strict=False)


@router.get("/best-map", summary="The best map", operation_id="get_best_map")
async def get_best_map(mission: OneMission) -> BestMapOut:
    """Return how it stands, and the latest one with its trails and tags.

    That one stays while the next is being made, and when the next fails.
    """
    best = mission.best_map
    found = {**best.value(), "is_current": best.is_current, **best.details()}
    return BestMapOut.model_validate(found, strict=False)


@router.get(
    "/best-map.png",
    summary="The best map's picture",
    operation_id="get_best_map_png",
    response_class=Response,
    responses=PNG,
)
async def get_best_map_png(
    mission: OneMission, if_none_match: Annotated[str | None, Header()] = None
) -> Response:
    """Return the latest picture: 0 unknown (transparent), 1 free, 2 occupied.

    The top row has the largest y.
    """
    image = mission.best_map.image
    if image is None:
        raise ApiError(404, "no_best_map", "There is no best map yet; POST to best-map to have one made.")
    return picture(image, if_none_match)
