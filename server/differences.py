"""Where an agent on board and its twin on the server differ.

They run the same code on the same log, so they must not.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

from server.robot import Robot, Told
from server.schemas.observations import OnboardWire

_TOLERANCE = 1e-9


def differences(robot: Robot, onboard: Sequence[OnboardWire]) -> list[dict[str, Any]]:
    """Return every value in which what was done on board differs from what the server's agent says."""
    found: list[dict[str, Any]] = []
    for item in onboard:
        told = robot.told.get(item.seq)
        if told is not None:
            found += [
                {"seq": item.seq, "what": what, "onboard": mine, "server": theirs}
                for what, mine, theirs in _pairs(item, told)
                if not _same(mine, theirs)
            ]
    return found


def _pairs(item: OnboardWire, told: Told) -> list[tuple[str, Any, Any]]:
    theirs = [(write.tag_id, base64.b64encode(write.memory).decode()) for write in told.command.writes]
    mine = [(write.tag_id, write.memory) for write in item.command.writes]
    return [
        ("pose.x_m", item.pose.x_m, told.pose.x),
        ("pose.y_m", item.pose.y_m, told.pose.y),
        ("pose.yaw_rad", item.pose.yaw_rad, told.pose.theta),
        ("command.linear_mps", item.command.linear_mps, told.command.linear_mps),
        ("command.angular_radps", item.command.angular_radps, told.command.angular_radps),
        ("command.drop_tag", item.command.drop_tag, told.command.drop_tag),
        ("command.writes", _text(mine), _text(theirs)),
    ]


def _text(writes: list[tuple[str, str]]) -> str:
    return ", ".join(f"{tag_id}: {memory}" for tag_id, memory in writes)


def _same(mine: Any, theirs: Any) -> bool:
    if isinstance(mine, float) and isinstance(theirs, float):
        return abs(mine - theirs) <= _TOLERANCE
    return bool(mine == theirs)
