"""Orders of an operator to one robot: they reach the agent in an observation, so that the log holds them.

Places are in the robot's map frame, in metres; whoever gives an order puts them there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

OrderKind = Literal["return", "hold", "resume", "go_to", "explore_here", "drop_tag", "methods"]
PLACED: frozenset[OrderKind] = frozenset({"go_to", "explore_here"})  # the kinds that need a place
OrderState = Literal["issued", "delivered", "done", "failed"]


@dataclass(frozen=True, slots=True)
class Methods:
    """How a robot explores, agrees with others and talks to them: the names of its methods.

    In an order an empty name leaves that method as it is.
    """

    explore: str = ""
    coordinate: str = ""
    communication: str = ""


@dataclass(frozen=True, slots=True)
class RobotOrder:
    """What a robot is told by an operator (``by``).

    ``place_m`` (x, y) for ``go_to`` and ``explore_here``, None otherwise; ``methods`` for ``methods`` alone.
    ``area_m``: the corners of what is to be explored round that place; without them, what is near it.
    """

    order_id: str
    kind: OrderKind
    by: str = ""
    place_m: tuple[float, float] | None = None
    methods: Methods = field(default_factory=Methods)
    area_m: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class OrderReport:
    """What became of an order, in words for whoever gave it."""

    order_id: str
    state: OrderState
    text: str
