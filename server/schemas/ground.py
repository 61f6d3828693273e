"""Layers of the ground on the wire."""

from __future__ import annotations

from pydantic import Field

from server.schemas.common import Wire
from server.schemas.findings import MapOut


class CoverageOut(Wire):
    """How well the ground was looked at."""

    map: MapOut = Field(description="Its picture: 0 unknown, 1 free, 2 safe, 3 cleared of victims.")
    free_m2: float = Field(description="All free ground.")
    safe_m2: float = Field(description="Of it, where a robot was within 3 m, in sight.")
    cleared_m2: float = Field(description="Of that, where a robot's camera has looked.")


class WayOut(Wire):
    """A robot's way, point by point."""

    robot_id: str
    points_m: list[tuple[float, float]]
    heard: list[bool] = Field(description="Whether it was heard from there, or told of it later.")


class ContactsOut(Wire):
    """Where robots were heard."""

    robots: list[WayOut]


class TagWindowOut(Wire):
    """The ground that a tag's memory tells of."""

    tag_id: str
    x_m: float
    y_m: float
    cell_m: float = Field(description="Side of a cell.")
    window: list[str] = Field(
        description="One text a row, north first and west to the left, the tag in the middle: `.` not seen,"
        " `o` covered with an open edge, `#` covered."
    )


class MemoriesOut(Wire):
    """What all tags' memories say of the ground."""

    tags: list[TagWindowOut]
