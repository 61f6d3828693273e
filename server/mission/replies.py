"""What a robot is told: which of its observations are new, and its next order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from robots.agent import merged_command
from robots.orders import RobotOrder
from robots.types import Command, Observation
from server.errors import ApiError
from server.robot import Robot
from server.schemas.convert import command_to_wire, order_to_wire, pose_to_wire


def fresh_of(robot: Robot, batch: Sequence[Observation]) -> list[Observation]:
    """Return the observations that are new.

    Raises:
        ApiError: a gap, or a stamp before an earlier one.
    """
    expected, stamp = robot.next_seq, robot.last_stamp_s
    fresh: list[Observation] = []
    for place, observation in enumerate(batch):
        if observation.seq < expected:
            continue
        if observation.seq > expected:
            raise ApiError(
                409,
                "gap",
                f"Observation {observation.seq} came, but {expected} is expected next;"
                f" send from next_seq {expected}.",
                f"observations.{place}.seq",
            )
        if stamp is not None and observation.stamp_s < stamp:
            raise ApiError(
                422,
                "stamp_backwards",
                f"stamp_s {observation.stamp_s} lies before {stamp} of the observation before it;"
                " a robot's clock must not run backwards.",
                f"observations.{place}.stamp_s",
            )
        fresh.append(observation)
        expected, stamp = expected + 1, observation.stamp_s
    return fresh


def reply_to(
    robot: Robot,
    batch: Sequence[Observation],
    accepted: int,
    duplicates: int,
    differences: list[dict[str, Any]],
    orders: Sequence[RobotOrder] = (),
) -> dict[str, Any]:
    """Return the reply to a batch: the order of its observations, or the last one; STOP before either.

    ``orders``: an operator's, for an agent on board.
    """
    told = [robot.told[o.seq] for o in batch if o.seq in robot.told]
    if not told and robot.told:
        told = [next(reversed(robot.told.values()))]
    command = merged_command([item.command for item in told]) if told else Command()
    robot.stopping.tell()
    if robot.held:
        command = Command()
    if robot.communication == "full" and robot.record.agent == "server":
        command = replace(command, say=None)  # the server has told the others
    return {
        "next_seq": robot.next_seq,
        "accepted": accepted,
        "duplicates": duplicates,
        "stop": robot.held,
        "pose": pose_to_wire(told[-1].pose) if told else None,
        "command": command_to_wire(command),
        "differences": differences,
        "orders": [order_to_wire(order) for order in orders],
    }
