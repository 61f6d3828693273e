"""Robots' tokens: made, listed, revoked."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from fastapi import APIRouter

from db.people_records import RobotTokenRecord
from server.api.common import ERRORS, Commander, TheAccess, TheChange
from server.people.audit import AuditedRoute
from server.schemas.people import NewRobotTokenOut, RobotTokenIn, RobotTokenOut, RobotTokensOut

router = APIRouter(prefix="/robot-tokens", tags=["people"], responses=ERRORS, route_class=AuditedRoute)


@router.get("", summary="All tokens of robots", operation_id="get_robot_tokens")
async def get_robot_tokens(access: TheAccess, by: Commander) -> RobotTokensOut:
    """Return every token without its secret, oldest first."""
    return RobotTokensOut(tokens=[RobotTokenOut(**_value(token)) for token in access.robot_tokens.all()])


@router.post("", status_code=201, summary="Make a token", operation_id="make_robot_token")
async def make_robot_token(
    body: RobotTokenIn, access: TheAccess, by: Commander, change: TheChange
) -> NewRobotTokenOut:
    """Make a token for robots of a mission, or for one of them; its secret is told once."""
    secret, token = await access.robot_tokens.make(body.label, body.mission_id, body.robot_id, by.name)
    change.subject = token.label
    return NewRobotTokenOut(**_value(token), token=secret)


@router.delete("/{token_id}", status_code=204, summary="Revoke a token", operation_id="revoke_robot_token")
async def revoke_robot_token(token_id: str, access: TheAccess, by: Commander, change: TheChange) -> None:
    """Let a token count no more, from this moment."""
    token = await access.robot_tokens.revoke(token_id)
    change.subject = token.label


def _value(token: RobotTokenRecord) -> dict[str, Any]:
    value = asdict(token)
    del value["secret_sha256"]
    return value
