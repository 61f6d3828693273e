"""Robots' tag graphs: whole, the latest replaces all earlier ones."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import Any

import numpy as np
from sqlalchemy import Connection, Table, delete, insert, select

from db.engine import Database
from db.tables import graph_edges, graph_vertices
from robots.graph_report import GraphReport
from robots.se2 import Array


class GraphStore:
    """Vertices (poses, tags) and edges (displacements, sightings) per robot."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def record_graph(self, mission_id: str, robot_id: str, graph: GraphReport) -> None:
        """Replace the graph of a robot."""
        owner = {"mission_id": mission_id, "robot_id": robot_id}

        def work(connection: Connection) -> None:
            _replace(connection, graph_vertices, owner, _vertices(graph))
            _replace(connection, graph_edges, owner, _edges(graph))

        await self._database.write(work)

    async def graph_of(self, mission_id: str, robot_id: str) -> GraphReport | None:
        """Return the graph of a robot, None when it has none yet."""
        return await self._database.read(lambda c: _graph(c, mission_id, robot_id))


def _replace(
    connection: Connection, table: Table, owner: dict[str, str], rows: Sequence[dict[str, Any]]
) -> None:
    connection.execute(
        delete(table).where(table.c.mission_id == owner["mission_id"], table.c.robot_id == owner["robot_id"])
    )
    if rows:
        connection.execute(insert(table), [{**owner, **row} for row in rows])


def _vertices(graph: GraphReport) -> list[dict[str, Any]]:
    poses = [
        {
            "kind": "pose",
            "number": number,
            "tag_id": None,
            "x_m": x,
            "y_m": y,
            "yaw_rad": yaw,
            "stamp_s": stamp,
            "imu_yaw_rad": None if isnan(imu) else imu,
        }
        for number, ((x, y, yaw), stamp, imu) in enumerate(
            zip(graph.poses.tolist(), graph.stamps_s.tolist(), graph.yaws_rad.tolist(), strict=True)
        )
    ]
    tags = [
        {
            "kind": "tag",
            "number": number,
            "tag_id": tag_id,
            "x_m": x,
            "y_m": y,
            "yaw_rad": None,
            "stamp_s": None,
            "imu_yaw_rad": None,
        }
        for number, (tag_id, (x, y)) in enumerate(zip(graph.tag_ids, graph.tags.tolist(), strict=True))
    ]
    return poses + tags


def _edges(graph: GraphReport) -> list[dict[str, Any]]:
    rows = [
        _edge("displacement", k, pair, pose, covariance)
        for k, (pair, pose, covariance) in enumerate(
            zip(graph.edge_pairs, graph.edge_poses, graph.edge_covariances, strict=True)
        )
    ]
    rows += [
        _edge("loop", k, pair, pose, covariance)
        for k, (pair, pose, covariance) in enumerate(
            zip(graph.loop_pairs, graph.loop_poses, graph.loop_covariances, strict=True)
        )
    ]
    rows += [
        _edge("sighting", k, pair, offset, covariance)
        for k, (pair, offset, covariance) in enumerate(
            zip(graph.sighting_pairs, graph.sighting_offsets, graph.sighting_covariances, strict=True)
        )
    ]
    rows += [
        _edge("meeting", k, (pose, None), offset, covariance, robot, float(stamp))
        for k, (pose, robot, stamp, offset, covariance) in enumerate(
            zip(
                graph.meeting_poses,
                graph.meeting_robots,
                graph.meeting_stamps_s,
                graph.meeting_offsets,
                graph.meeting_covariances,
                strict=True,
            )
        )
    ]
    return rows


def _edge(
    kind: str,
    number: int,
    pair: Sequence[int | None] | Array,
    pose: Array,
    covariance: Array,
    other: str | None = None,
    stamp_s: float | None = None,
) -> dict[str, Any]:
    ends = [None if end is None else int(end) for end in pair]
    return {
        "kind": kind,
        "number": number,
        "from_number": ends[0],
        "to_number": ends[1],
        "x_m": float(pose[0]),
        "y_m": float(pose[1]),
        "yaw_rad": float(pose[2]) if len(pose) > 2 else None,
        "covariance": covariance.ravel().tolist(),
        "other_robot_id": other,
        "stamp_s": stamp_s,
    }


def _graph(connection: Connection, mission_id: str, robot_id: str) -> GraphReport | None:
    def rows(table: Table, kind: str) -> list[Any]:
        query = select(table).where(
            table.c.mission_id == mission_id, table.c.robot_id == robot_id, table.c.kind == kind
        )
        return list(connection.execute(query.order_by(table.c.number)))

    poses, tags = rows(graph_vertices, "pose"), rows(graph_vertices, "tag")
    if not poses:
        return None
    edges, sightings = rows(graph_edges, "displacement"), rows(graph_edges, "sighting")
    loops, meetings = rows(graph_edges, "loop"), rows(graph_edges, "meeting")
    return GraphReport(
        poses=_array([(r.x_m, r.y_m, r.yaw_rad) for r in poses], 3),
        stamps_s=_array([r.stamp_s for r in poses]),
        yaws_rad=_array([np.nan if r.imu_yaw_rad is None else r.imu_yaw_rad for r in poses]),
        tag_ids=tuple(r.tag_id for r in tags),
        tags=_array([(r.x_m, r.y_m) for r in tags], 2),
        edge_pairs=_array([(r.from_number, r.to_number) for r in edges], 2).astype(np.int64),
        edge_poses=_array([(r.x_m, r.y_m, r.yaw_rad) for r in edges], 3),
        edge_covariances=_array([r.covariance for r in edges], 3, 3),
        sighting_pairs=_array([(r.from_number, r.to_number) for r in sightings], 2).astype(np.int64),
        sighting_offsets=_array([(r.x_m, r.y_m) for r in sightings], 2),
        sighting_covariances=_array([r.covariance for r in sightings], 2, 2),
        loop_pairs=_array([(r.from_number, r.to_number) for r in loops], 2).astype(np.int64),
        loop_poses=_array([(r.x_m, r.y_m, r.yaw_rad) for r in loops], 3),
        loop_covariances=_array([r.covariance for r in loops], 3, 3),
        meeting_robots=tuple(r.other_robot_id for r in meetings),
        meeting_poses=_array([r.from_number for r in meetings]).astype(np.int64),
        meeting_stamps_s=_array([r.stamp_s for r in meetings]),
        meeting_offsets=_array([(r.x_m, r.y_m) for r in meetings], 2),
        meeting_covariances=_array([r.covariance for r in meetings], 2, 2),
    )


def _array(values: list[Any], *shape: int) -> Array:
    return np.asarray(values, dtype=np.float64).reshape(-1, *shape)
