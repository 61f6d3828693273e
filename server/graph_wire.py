"""A tag graph as it stands on the wire."""

from __future__ import annotations

import numpy as np

from robots.types import GraphReport
from server.schemas.findings import GraphEdgeOut, GraphVertexOut, RobotGraphOut


def graph_out(robot_id: str, graph: GraphReport) -> RobotGraphOut:
    """Return a robot's graph: poses, tags, displacements and sightings."""
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
    displacements = [
        GraphEdgeOut(
            kind="displacement",
            from_number=int(pair[0]),
            to_number=int(pair[1]),
            x_m=float(pose[0]),
            y_m=float(pose[1]),
            yaw_rad=float(pose[2]),
            covariance=np.asarray(covariance).tolist(),
        )
        for pair, pose, covariance in zip(
            graph.edge_pairs, graph.edge_poses, graph.edge_covariances, strict=True
        )
    ]
    sightings = [
        GraphEdgeOut(
            kind="sighting",
            from_number=int(pair[0]),
            to_number=int(pair[1]),
            x_m=float(offset[0]),
            y_m=float(offset[1]),
            yaw_rad=None,
            covariance=np.asarray(covariance).tolist(),
        )
        for pair, offset, covariance in zip(
            graph.sighting_pairs, graph.sighting_offsets, graph.sighting_covariances, strict=True
        )
    ]
    return RobotGraphOut(robot_id=robot_id, vertices=[*poses, *tags], edges=[*displacements, *sightings])
