"""A tag graph as it stands on the wire."""

from __future__ import annotations

from collections.abc import Iterator

from robots.estimation.ranges.views import as_sightings
from robots.graph_report import GraphReport, IntArray
from robots.se2 import Array
from server.schemas.findings import GraphEdgeOut, GraphVertexOut, RobotGraphOut


def graph_out(robot_id: str, graph: GraphReport) -> RobotGraphOut:
    """Return a robot's graph: poses, tags, and everything that was measured between them.

    What was seen by range is a sighting where range and, without a bearing, the robot's own map put it.
    """
    graph = as_sightings(graph)
    poses = [
        GraphVertexOut(kind="pose", number=k, tag_id=None, x_m=x, y_m=y, yaw_rad=yaw, stamp_s=stamp)
        for k, ((x, y, yaw), stamp) in enumerate(
            zip(graph.poses.tolist(), graph.stamps_s.tolist(), strict=True)
        )
    ]
    tags = [
        GraphVertexOut(kind="tag", number=k, tag_id=tag_id, x_m=x, y_m=y, yaw_rad=None, stamp_s=None)
        for k, (tag_id, (x, y)) in enumerate(zip(graph.tag_ids, graph.tags.tolist(), strict=True))
    ]
    edges = [
        *_links("displacement", graph.edge_pairs, graph.edge_poses, graph.edge_covariances),
        *_links("loop", graph.loop_pairs, graph.loop_poses, graph.loop_covariances),
        *_links("sighting", graph.sighting_pairs, graph.sighting_offsets, graph.sighting_covariances),
        *_meetings(graph),
    ]
    return RobotGraphOut(robot_id=robot_id, vertices=[*poses, *tags], edges=edges)


def _links(kind: str, pairs: IntArray, measured: Array, covariances: Array) -> Iterator[GraphEdgeOut]:
    for pair, values, covariance in zip(pairs.tolist(), measured.tolist(), covariances, strict=True):
        yield GraphEdgeOut(
            kind=kind,
            from_number=pair[0],
            to_number=pair[1],
            x_m=values[0],
            y_m=values[1],
            yaw_rad=values[2] if len(values) > 2 else None,
            covariance=covariance.tolist(),
        )


def _meetings(graph: GraphReport) -> Iterator[GraphEdgeOut]:
    for k, robot_id in enumerate(graph.meeting_robots):
        yield GraphEdgeOut(
            kind="meeting",
            from_number=int(graph.meeting_poses[k]),
            to_number=None,
            x_m=float(graph.meeting_offsets[k, 0]),
            y_m=float(graph.meeting_offsets[k, 1]),
            yaw_rad=None,
            covariance=graph.meeting_covariances[k].tolist(),
            robot_id=robot_id,
            stamp_s=float(graph.meeting_stamps_s[k]),
        )
