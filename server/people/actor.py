"""Who makes a request, and what they may do."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Literal

from db.people_records import Role

RANKS: dict[Role, int] = {"viewer": 0, "responder": 1, "operator": 2, "commander": 3}
"""Roles in order: each may do what those before it may."""


@dataclass(frozen=True, slots=True)
class Actor:
    """A person with a role, or a robot with a token.

    ``mission_id`` and ``robot_id``: what a robot's token is for, None for all. ``over`` is set when the
    session ends or the token is revoked; whoever holds a connection open for the actor closes it then.
    """

    name: str
    role: Role | Literal["robot"]
    mission_id: str | None = None
    robot_id: str | None = None
    over: asyncio.Event = field(default_factory=asyncio.Event, compare=False)

    @property
    def is_robot(self) -> bool:
        """Whether it is no person."""
        return self.role == "robot"

    def may(self, role: Role) -> bool:
        """Say whether a person has this role or one above it; a robot may do what a viewer may."""
        return role == "viewer" if self.role == "robot" else RANKS[self.role] >= RANKS[role]

    def is_for(self, mission_id: str | None, robot_id: str | None = None) -> bool:
        """Say whether a robot's token is for this mission and robot; people are for all."""
        return self.mission_id in (None, mission_id) and (
            robot_id is None or self.robot_id in (None, robot_id)
        )
