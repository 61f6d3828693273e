"""What robots send: the log of a mission, which is kept as such and not in the audit log."""

from __future__ import annotations

from fastapi import APIRouter, Request

from server.api.common import ERRORS, OneMission, RobotOrOperator
from server.schemas.convert import observation_from_wire
from server.schemas.observations import BatchIn, BatchOut

router = APIRouter(prefix="/missions/{mission_id}/robots", tags=["robots"], responses=ERRORS)


@router.post("/{robot_id}/observations", summary="Send observations", operation_id="post_observations")
async def post_observations(
    robot_id: str, body: BatchIn, mission: OneMission, request: Request, by: RobotOrOperator
) -> BatchOut:
    """Take in a batch, ordered by seq, and answer with the next order.

    What was accepted is saved before the agent sees it. Known seqs are counted as duplicates and change
    nothing, but an event tells where one differs from what is known; a gap is refused with the seq that is
    expected.
    """
    batch = [observation_from_wire(observation) for observation in body.observations]
    sender = request.client.host if request.client is not None else "nowhere"
    return BatchOut.model_validate(await mission.ingest(robot_id, batch, body.onboard or [], sender))
