"""Routes on the wire."""

from __future__ import annotations

from pydantic import Field

from server.schemas.common import Wire


class LegOut(Wire):
    """From one tag to the next."""

    from_tag: str
    to_tag: str
    distance_m: float
    bearing_deg: float = Field(description="Compass bearing at its start, 0 to 360.")
    text: str
    points_m: list[list[float]] = Field(description="Where it bends, x and y of each point, ends included.")
    uncertain: bool = Field(description="Length and direction are but a guess.")
    hazards: list[str] = Field(description="What it passes.")


class LastOut(Wire):
    """The last piece, from the last tag to what is looked for."""

    from_tag: str
    distance_m: float
    bearing_deg: float
    text: str


class RouteOut(Wire):
    """A route for people: tags one after the other, along what robots drove."""

    from_tag: str
    to: str
    x_m: float
    y_m: float
    distance_m: float
    legs: list[LegOut]
    last: LastOut | None
