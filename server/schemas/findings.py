"""Tags, annotations, the map and the graph on the wire."""

from __future__ import annotations

from typing import Any, Self

from pydantic import ConfigDict, Field, model_validator

from db.records import AnnotationKind, TagState
from server.schemas.common import Corner, Covariance, Metres, Name, Wire
from server.schemas.nodes import NodeOut


class TagOut(Wire):
    """A tag where the team map places it."""

    tag_id: str
    x_m: float
    y_m: float
    covariance: Covariance
    sightings: int
    robots: list[str]
    state: TagState = Field(
        description="`sound`; `moved`: lies here now; `cloned`: one of several of that id, the others end in"
        " `#2` and so on; `doubtful`: a reading contradicted all others."
    )
    notice: str = Field(description="What is wrong with a tag that is not sound, else empty.")
    sensors: NodeOut | None = Field(None, description="What it measured last, if it is an active node.")


class MemoryOut(Wire):
    """What a tag's memory says."""

    tag_id: str
    cell_m: float = Field(description="Side of a cell of the window.")
    memory: dict[str, Any] | None = Field(
        description="Null while nobody has read or written it. As `waymark tag decode` tells it: `window`"
        " and `visited` have one text a row, north first and west to the left, the tag in the middle; `.` is"
        " not seen, `o` open, `#` closed."
    )
    sentences: list[str] = Field(description="What it holds beside the ground, for people.")


class TagsOut(Wire):
    """Tags, and the pairs of tags between which a robot has driven."""

    tags: list[TagOut]
    links: list[tuple[str, str]]


class AnnotationIn(Wire):
    """Something to write on the map: at a place in the world frame, at a tag, or over an area."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"kind": "hazard", "text": "smell of gas", "x_m": 3.0, "y_m": -1.5},
                {"kind": "note", "text": "stairs go down here", "tag_id": "A4"},
                {"kind": "searched", "text": "", "area_m": [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]},
            ]
        }
    )

    kind: AnnotationKind
    text: str = Field(max_length=2000)
    x_m: Metres | None = None
    y_m: Metres | None = None
    tag_id: Name | None = None
    area_m: list[Corner] = Field(
        default_factory=list, max_length=500, description="Corners of the area, x and y of each."
    )

    @model_validator(mode="after")
    def _has_one_place(self) -> Self:
        at_point = self.x_m is not None and self.y_m is not None
        partly = (self.x_m is None) != (self.y_m is None)
        if partly or at_point + (self.tag_id is not None) + bool(self.area_m) != 1:
            raise ValueError("give either x_m and y_m, or tag_id, or area_m")
        if 0 < len(self.area_m) < 3:
            raise ValueError("area_m needs three corners or more")
        return self


class AnnotationOut(Wire):
    """An annotation."""

    annotation_id: str
    kind: AnnotationKind
    text: str
    x_m: float | None
    y_m: float | None
    tag_id: str | None
    area_m: list[list[float]]
    by: str
    created_unix_s: float
    changed_unix_s: float


class AnnotationsOut(Wire):
    """All annotations, oldest first."""

    annotations: list[AnnotationOut]


class MapOut(Wire):
    """The map that is served as a picture: row 0 is the top, farthest along y."""

    version: int
    width: int = Field(description="In cells.")
    height: int = Field(description="In cells.")
    resolution_m: float
    origin_m: tuple[float, float] = Field(description="World coordinates of the lower left corner.")
    explored_m2: float = Field(description="Free ground on it: what the team has explored.")
    png: str = Field(description="Address of the picture: 0 unknown (transparent), 1 free, 2 occupied.")


class GraphVertexOut(Wire):
    """A pose or a tag in a robot's map frame."""

    kind: str = Field(description="`pose` or `tag`.")
    number: int
    tag_id: str | None
    x_m: float
    y_m: float
    yaw_rad: float | None
    stamp_s: float | None


class GraphEdgeOut(Wire):
    """What was measured from a pose, in its frame: another pose, a tag, or another robot."""

    kind: str = Field(
        description="`displacement` (driven), `loop` (matched by laser), `sighting` of a tag, or `meeting`."
    )
    from_number: int
    to_number: int | None = Field(description="Pose or tag; null for a meeting.")
    x_m: float
    y_m: float
    yaw_rad: float | None
    covariance: list[list[float]]
    robot_id: str | None = Field(default=None, description="The robot that was met.")
    stamp_s: float | None = Field(default=None, description="When it was met.")


class RobotGraphOut(Wire):
    """The tag graph of a robot."""

    robot_id: str
    vertices: list[GraphVertexOut]
    edges: list[GraphEdgeOut]


class GraphsOut(Wire):
    """The tag graphs of all robots."""

    graphs: list[RobotGraphOut]
