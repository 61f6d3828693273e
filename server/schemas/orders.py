"""Orders of operators, and the methods that robots explore by, on the wire."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import ConfigDict, Field, model_validator

from robots.orders import PLACED, OrderKind, OrderState
from server.schemas.common import Corner, Metres, Name, Wire

MAX_ORDERS = 16  # in one observation
Area = Annotated[
    list[Corner],
    Field(max_length=500, description="For explore_here: the corners of the area, x and y of each."),
]
Method = Annotated[str, Field(max_length=40, description="The name of a method; without it, it stays.")]


class RobotOrderWire(Wire):
    """An operator's order as its robot is told, with its place in the robot's map frame."""

    order_id: Name
    kind: OrderKind
    by: str = Field("", max_length=200, description="Who ordered it.")
    x_m: Metres | None = None
    y_m: Metres | None = None
    area_m: Area = Field(default_factory=list)
    explore: Method = ""
    coordinate: Method = ""
    communication: Method = ""


class OrderIn(Wire):
    """An order to a robot."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"kind": "return"},
                {"kind": "go_to", "x_m": 12.5, "y_m": 3.0},
            ]
        }
    )

    kind: Annotated[OrderKind, Field(description="What to do; go_to and explore_here need a place.")]
    x_m: Metres | None = Field(None, description="The place, in the world frame.")
    y_m: Metres | None = Field(None, description="The place, in the world frame.")
    area_m: Area = Field(default_factory=list)

    @model_validator(mode="after")
    def _has_what_it_needs(self) -> Self:
        placed = self.x_m is not None and self.y_m is not None
        if self.kind in PLACED and not placed:
            raise ValueError(f"{self.kind} needs a place; give x_m and y_m")
        if self.kind not in PLACED and (self.x_m is not None or self.y_m is not None):
            raise ValueError(f"{self.kind} has no place; leave x_m and y_m out")
        if self.area_m and (self.kind != "explore_here" or len(self.area_m) < 3):
            raise ValueError("area_m is for explore_here, and has three corners or more")
        if self.kind == "methods":
            raise ValueError("methods are changed by PATCH on the robot itself")
        return self


class MethodsIn(Wire):
    """Methods to change; those left out stay as they are."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"explore": "nearest"}]})

    explore: Method = ""
    coordinate: Method = ""
    communication: Method = ""


class MethodsOut(Wire):
    """The names of all methods."""

    explore: list[str] = Field(description="How a robot weighs where to go.")
    coordinate: list[str] = Field(description="How it agrees with the others.")
    communication: list[str] = Field(description="Who hears whom.")


class OrderOut(Wire):
    """An order and what has become of it."""

    order_id: str
    robot_id: str
    kind: OrderKind
    by: str
    issued_unix_s: float
    x_m: float | None
    y_m: float | None
    area_m: list[list[float]]
    explore: str
    coordinate: str
    communication: str
    state: OrderState = Field(description="Issued, delivered with an observation, done, or failed.")
    text: str = Field(description="What the robot says about it.")


class OrdersOut(Wire):
    """The orders to a robot, the latest first."""

    orders: list[OrderOut]


class FrontierOut(Wire):
    """An edge of the unknown that a robot could go to, in the world frame."""

    x_m: float
    y_m: float
    length_m: float
    worth_m: float = Field(description="What it is worth by the robot's strategy, in metres of way.")
    chosen: bool = Field(description="The robot is on its way there.")


class FrontiersOut(Wire):
    """The edges of the unknown as a robot weighed them last, the best first."""

    robot_id: str
    frontiers: list[FrontierOut]
