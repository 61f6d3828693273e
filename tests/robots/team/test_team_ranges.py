"""Robots that see tags, and one another, by range: one batch solve of all, with or without bearings."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from robots.graph_report import GraphReport
from robots.se2 import Pose2
from robots.team.history import History
from robots.team.joint import JointSolution, solve_together
from robots.team.laser_loops import LaserLoops

NODES = {"n1": (2.0, 4.0), "n2": (8.0, 5.0), "n3": (11.0, -2.0), "n4": (4.0, -3.0)}
STEP_SD = np.array([0.02, 0.005, 0.01])
RANGE_SD, BEARING_SD = 0.1, 0.02


def way(name: str) -> list[Pose2]:
    """Round the middle of the nodes: r1 from the left, r2 from the right, half a metre a step."""
    pose = Pose2(0.0, -1.0, 0.0) if name == "r1" else Pose2(10.0, 3.0, np.pi)
    poses = [pose]
    for k in range(1, 90):
        pose = pose @ Pose2(0.5, 0.0, np.pi / 2 if k % 18 in (0, 10) else 0.0)
        poses.append(pose)
    return poses


def report(name: str, rng: np.random.Generator, bearings: bool, scale: float) -> GraphReport:
    """What the robot measured, in a map frame of its own that begins at its start."""
    truth = way(name)
    steps = [a.between(b).as_array() for a, b in pairwise(truth)]
    edges = [step + STEP_SD * rng.normal(size=3) for step in steps]
    reckoned = [Pose2()]
    for edge in edges:
        reckoned.append(reckoned[-1] @ Pose2.from_array(edge))
    pairs = np.array([(i, j) for i in range(len(truth)) for j in range(len(NODES))])
    seen = np.array([truth[i].inverse().transform_point(*list(NODES.values())[j]) for i, j in pairs])
    places = np.array([truth[0].inverse().transform_point(*place) for place in NODES.values()])
    count = len(pairs)
    angles = np.arctan2(seen[:, 1], seen[:, 0]) + BEARING_SD * rng.normal(size=count)
    others = way("r2" if name == "r1" else "r1")
    met = np.arange(0, len(truth), 3)
    offsets = np.array([truth[i].inverse().transform_point(others[i].x, others[i].y) for i in met])
    return GraphReport(
        poses=np.array([pose.as_array() for pose in reckoned]),
        stamps_s=np.arange(len(truth), dtype=float),
        yaws_rad=np.full(len(truth), np.nan),
        tag_ids=tuple(NODES),
        tags=places + 0.1 * rng.normal(size=places.shape),
        edge_pairs=np.column_stack([np.arange(len(edges)), np.arange(1, len(truth))]),
        edge_poses=np.array(edges),
        edge_covariances=np.tile(np.diag(STEP_SD**2), (len(edges), 1, 1)),
        sighting_pairs=np.zeros((0, 2), np.int64),
        sighting_offsets=np.zeros((0, 2)),
        sighting_covariances=np.zeros((0, 2, 2)),
        meeting_robots=("r2" if name == "r1" else "r1",) * len(met),
        meeting_poses=met,
        meeting_stamps_s=met.astype(float),
        meeting_offsets=offsets + 0.05 * rng.normal(size=offsets.shape),
        meeting_covariances=np.tile(np.eye(2) * 0.05**2, (len(met), 1, 1)),
        meeting_bases=np.zeros((len(met), 3)),
        range_pairs=pairs,
        range_poses=np.zeros((count, 3)),
        ranges_m=(1.0 if bearings else scale) * np.hypot(*seen.T) + RANGE_SD * rng.normal(size=count),
        range_sds_m=np.full(count, RANGE_SD),
        bearings_rad=angles if bearings else np.full(count, np.nan),
        bearing_sds_rad=np.full(count, BEARING_SD if bearings else np.nan),
        range_scale=1.0 if bearings else scale + 0.02,
        range_offsets_m=np.zeros(len(NODES)),
    )


def joint(graphs: dict[str, GraphReport]) -> JointSolution:
    histories = {}
    for name, graph in graphs.items():
        histories[name] = History()
        for k, stamp in enumerate(graph.stamps_s):
            histories[name].put(k, float(stamp), k, Pose2())
    empty, submaps = dict.fromkeys(graphs), {name: {} for name in graphs}
    return solve_together(graphs, empty, histories, submaps, LaserLoops(), "gauss-newton")


def thinned(graph: GraphReport, every: int) -> GraphReport:
    kept = graph.range_pairs[:, 0] % every == 0
    rows = ("range_pairs", "range_poses", "ranges_m", "range_sds_m", "bearings_rad", "bearing_sds_rad")
    return replace(graph, **{name: getattr(graph, name)[kept] for name in rows})


def both(bearings: bool) -> dict[str, GraphReport]:
    rng = np.random.default_rng(5)
    return {"r1": report("r1", rng, bearings, 1.05), "r2": report("r2", rng, bearings, 1.09)}


def errors(name: str, poses: np.ndarray) -> np.ndarray:
    """Distances (n,) of poses in r1's map frame from the truth."""
    start = way("r1")[0].inverse()
    there = np.array([start.transform_point(pose.x, pose.y) for pose in way(name)])
    return np.hypot(*(poses[:, :2] - there).T)


@pytest.mark.parametrize("bearings", [True, False])
def test_maps_of_nodes_become_one_whatever_their_frames_and_radios(bearings: bool) -> None:
    graphs = both(bearings)
    solution = joint(graphs)
    assert solution.located == {"r1", "r2"}
    for name, poses in solution.anchors.items():
        assert errors(name, poses).mean() < 0.15
    start = way("r1")[0].inverse()
    for tag in solution.tags:
        assert np.hypot(*(np.array([tag.x_m, tag.y_m]) - start.transform_point(*NODES[tag.tag_id]))) < 0.25
        assert tag.sightings == 180
        assert tag.robots == ("r1", "r2")
    assert np.linalg.eigvalsh(solution.covariances["r2"])[0] > 0.0
    assert not solution.notices


def error_m(graphs: dict[str, GraphReport]) -> float:
    return float(np.mean([errors(name, poses).mean() for name, poses in joint(graphs).anchors.items()]))


def test_seeing_one_another_helps_and_where_the_seer_stood_counts() -> None:
    vague = {
        name: replace(graph, range_sds_m=graph.range_sds_m * 30, bearing_sds_rad=graph.bearing_sds_rad * 30)
        for name, graph in both(True).items()
    }
    none = np.zeros(0)
    unmet = {
        name: replace(
            graph,
            meeting_robots=(),
            meeting_poses=np.zeros(0, np.int64),
            meeting_stamps_s=none,
            meeting_offsets=none.reshape(0, 2),
            meeting_covariances=none.reshape(0, 2, 2),
            meeting_bases=none.reshape(0, 3),
        )
        for name, graph in vague.items()
    }
    assert error_m(vague) < error_m(unmet)
    # the same places, seen from a base half a metre behind its anchor that faces elsewhere
    behind = np.array([-0.5, 0.1, 2.0])
    moved = {
        name: replace(graph, meeting_bases=np.tile(behind, (len(graph.meeting_poses), 1)))
        for name, graph in vague.items()
    }
    assert error_m(moved) == pytest.approx(error_m(vague), abs=0.05)


def test_the_joint_map_is_a_function_of_the_reports() -> None:
    graphs = both(False)
    first, second = joint(graphs), joint(dict(reversed(graphs.items())))
    for name in graphs:
        np.testing.assert_array_equal(first.anchors[name], second.anchors[name])


@pytest.mark.parametrize("field", ["ranges_m", "range_sds_m", "range_poses"])
def test_a_report_with_ranges_that_are_no_numbers_is_left_out_and_told(field: str) -> None:
    graphs = both(True)
    broken = getattr(graphs["r2"], field).copy()
    broken[7] = np.nan
    solution = joint(graphs | {"r2": replace(graphs["r2"], **{field: broken})})
    assert solution.located == {"r1"}
    assert [notice.about for notice in solution.notices] == ["r2"]
    assert errors("r1", solution.anchors["r1"]).mean() < 0.15


@pytest.mark.parametrize("moved_m", [0.0, 2.0])
def test_of_tags_seen_by_range_those_are_tested_that_were_passed(moved_m: float) -> None:
    graphs = {name: thinned(graph, 6) for name, graph in both(True).items()}
    under, pose = [20, 60], {}
    for k in under:  # n1 lay under the antenna twice, the second time elsewhere
        x, y = NODES["n1"]
        place = (x + (moved_m if k == 60 else 0.0), y)
        pose[k] = way("r1")[k].inverse().transform_point(*place)
    graphs["r1"] = replace(
        graphs["r1"],
        sighting_pairs=np.array([[k, 0] for k in under]),
        sighting_offsets=np.array([pose[k] for k in under]),
        sighting_covariances=np.tile(np.eye(2) * 0.01, (2, 1, 1)),
    )
    solution = joint(graphs)
    assert {notice.about for notice in solution.notices} == ({"n1"} if moved_m else set())
    assert errors("r1", solution.anchors["r1"]).mean() < 0.2


def test_the_place_of_a_node_is_as_sure_as_walls_let_it() -> None:
    """All ranges through one wall are off alike: 180 of them claimed a node to a few centimetres."""
    nees = []
    start = way("r1")[0].inverse()
    for seed in range(4):
        rng = np.random.default_rng([seed, 3])
        walls = 0.7 * RANGE_SD * rng.normal(size=(len(NODES), 8))
        graphs = {}
        for name, graph in both(False).items():
            here = np.array([(pose.x, pose.y) for pose in way(name)])[graph.range_pairs[:, 0]]
            away = np.array(list(NODES.values()))[graph.range_pairs[:, 1]] - here
            sector = np.floor(np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4.0)).astype(int)
            graphs[name] = replace(graph, ranges_m=graph.ranges_m + walls[graph.range_pairs[:, 1], sector])
        for tag in joint(graphs).tags:
            off = np.array([tag.x_m, tag.y_m]) - start.transform_point(*NODES[tag.tag_id])
            nees.append(float(off @ np.linalg.solve(tag.covariance, off)))
    assert 0.5 < np.median(nees) < 3.0  # 1.39 of a normal law
    assert np.mean(np.array(nees) < 6.0) > 0.8  # 0.95
