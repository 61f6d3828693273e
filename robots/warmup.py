"""Compiling the numerical kernels ahead of time.

It takes seconds at the first start of a machine, nothing afterwards.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians

import numpy as np

from robots.agent import RobotAgent
from robots.config import AgentConfig, MappingConfig, PlanningConfig
from robots.estimation.contradiction import share_seen_through
from robots.estimation.ekf.filter import EkfFilter
from robots.estimation.graph.solve import solve
from robots.estimation.radio.locating import Heard, Plan, Radio, locate
from robots.estimation.rslam.range_slam import RangeSlam
from robots.estimation.scans.cloud_matching import Cloud, Window, match_clouds
from robots.estimation.scans.points import scan_points
from robots.estimation.tag_filter import RangeSighting
from robots.estimation.tag_graph.graph import TagGraph, graph_problem
from robots.estimation.tag_graph.smoothing import smooth_radio
from robots.exploration.frontiers import Frontier
from robots.exploration.settings import SafeGroundConfig
from robots.exploration.strategies.sight import Sight
from robots.exploration.strategies.three_grids import find_candidates, three_grids
from robots.exploration.strategies.waymark import Waymark
from robots.exploration.strategy import ExplorationView
from robots.exploration.team.team_ground import TeamGround, tiles_of
from robots.exploration.team.team_message import Patch, Tile
from robots.exploration.told.claims import Claims, KnownTag
from robots.exploration.told.far_sight import FarSight
from robots.mapping.fused import FusedGrid
from robots.planning.plan_grid import FREE, UNKNOWN, PlanGrid
from robots.planning.travel import travel_costs
from robots.routes.place_kind import kind_of
from robots.se2 import GaussianPose, Pose2
from robots.tags.memory import CLOSED, TagMemory
from robots.team import StartPose, TeamGrid, TeamMap
from robots.types import HeatReading, ImuReading, LaserScan, Observation, TagSighting, WheelEncoders


def warm_up() -> None:
    """Drive an agent and a team map a few steps, so that every kernel is compiled and cached."""
    agent = RobotAgent("warm-up", AgentConfig())
    angles = np.linspace(-2.0, 2.0, 240)
    ranges = np.minimum(
        2.0 / np.maximum(np.abs(np.cos(angles)), 1e-3), 2.5 / np.maximum(np.abs(np.sin(angles)), 1e-3)
    )
    scan = LaserScan(np.minimum(ranges, 4.0).astype(np.float32), -2.0, float(angles[1] - angles[0]), 4.0)
    team = TeamMap()
    team.add_robot("warm-up", StartPose(Pose2(), 0.1, radians(1.0)))
    team.add_robot("warm-up-too", None)
    for seq in range(12):
        update = agent.step(
            Observation(
                seq=seq,
                stamp_s=0.2 * seq,
                odometry=WheelEncoders(0.02, 0.02, 0.02, 0.02),
                imu=ImuReading(0.0),
                scan=scan,
                tag_sightings=(TagSighting(f"warm-{seq % 3}"),) if seq > 3 else (),
                heat=(HeatReading(0.1, 1.5, 0.9),) if seq == 8 else (),
                bumper=seq == 9,
            )
        )
        team.put("warm-up", update)
    for name in ("warm-up", "warm-up-too"):  # they share tags, so their surroundings are matched
        team.put(name, agent.report())
    team.solve()
    RobotAgent.restore(agent.snapshot()).smoothed()
    _warm_up_bad_starts()
    _warm_up_loops(scan)
    _warm_up_ranges()
    _warm_up_radio_tags()
    _warm_up_batch()
    _warm_up_strategies()
    _warm_up_team_ground()
    _warm_up_places()


def _warm_up_places() -> None:
    """Ask in a room where one is."""
    cells = np.zeros((40, 40), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    kind_of(TeamGrid(cells, (0.0, 0.0), 0.1, 1), 2.0, 2.0)


def _warm_up_team_ground() -> None:
    """Tell a neighbour of a small map, and draw it into its own."""
    mapping, fused = MappingConfig(), FusedGrid(MappingConfig().resolution_m)
    fused.put("warm", 0, Pose2(), np.full((8, 8), -mapping.miss_logodds, np.int16))
    found = tiles_of(fused, Pose2(), np.zeros(2), 1.0, mapping)
    ground = TeamGround()
    ground.take(Patch("warm", 0, 1, tuple(Tile(*key, 1, cells) for key, cells in found.items())))
    ground.overlaid(fused, 2, Pose2(), mapping)


def _warm_up_strategies() -> None:
    """Look for candidates in a small room."""
    cells = np.full((60, 60), FREE, np.uint8)
    cells[0] = UNKNOWN
    grid = PlanGrid(cells, np.full((60, 60), 5, np.uint8), (0.0, 0.0), 0.1)
    trail, sight = np.array([[0.5, 0.5, 0.0, 0.0]]), Sight()
    for _ in range(2):  # the second time looks for what changed
        find_candidates(grid, travel_costs(grid, 5, 5), three_grids(grid, trail, 3.0, sight))
    claims = Claims()
    claims.hear("warm", TagMemory(np.full((3, 3), CLOSED, np.uint8)))
    tags = claims.tags({"warm": (3.0, 0.0)}.get)
    survey, frontiers = claims.survey(grid, tags), (Frontier((1, 30), (3.0, 0.2), 1.0, 1.0),)
    view = ExplorationView(Pose2(), frontiers, lambda: survey, grid=grid, trail=np.zeros((20, 4)))
    Waymark().worths(view)
    swept = replace(
        view, costs=travel_costs(grid, 5, 5), settings=PlanningConfig(safe=SafeGroundConfig(sweep=True))
    )
    waymark = Waymark()
    begun = waymark.candidates(swept)
    waymark.candidates(replace(swept, goal_m=begun[0].goal_m))
    waymark.worths(swept)
    _warm_up_small_maps(tags)


def _warm_up_small_maps(tags: tuple[KnownTag, ...]) -> None:
    """Look for ways along tags out of a small room."""
    cells = np.full((60, 60), FREE, np.uint8)
    cells[:, 58] = UNKNOWN
    grid = PlanGrid(cells, np.full((60, 60), 5, np.uint8), (0.0, 0.0), 0.1)
    view = ExplorationView(
        Pose2(1.0, 1.0, 0.0), (), lambda: Claims().survey(grid, ()), grid=grid,
        costs=travel_costs(grid, 5, 5), tags=tags, settings=PlanningConfig(min_frontier_m=100.0),
    )  # fmt: skip
    sight = FarSight()
    for _ in range(2):
        sight.candidates(view)
    sight.untold(np.array([[1.0, 1.0]]), 1.0)


def _warm_up_ranges() -> None:
    """Drive among radio nodes until one has its place."""
    slam = RangeSlam("warm-up", AgentConfig(), Pose2())
    for turn in range(40):
        slam.predict(GaussianPose(Pose2(0.5, 0.0, 0.2), np.eye(3) * 1e-4))
        here = slam.belief.mean
        slam.see(RangeSighting("warm", float(turn), float(np.hypot(here.x - 5.0, here.y - 4.0)), 0.1))
        slam.anchor()
    slam.see_heading(slam.belief.mean.theta, 0.1)
    slam.tags()
    heard = [Heard("warm", 0.0, 0.0, 0.1, 2.0, 0.4), Heard("warm-too", 1.0, 0.0, 0.1, 2.0, 0.0, 0.1)]
    locate(heard, Radio(0.4, 0.2, 35.0), None, Plan(np.ones((8, 8), np.uint8), (0.0, 0.0), 0.5))


def _warm_up_radio_tags() -> None:
    """Let a filter hear tags by range and bearing, and one by range alone."""
    ekf = EkfFilter("warm-up", AgentConfig(), Pose2())
    for k in range(4):
        ekf.predict(GaussianPose(Pose2(0.1, 0.0, 0.1), np.eye(3) * 1e-4))
        ekf.see_heading(0.1 * k, 0.1)
        ekf.see(RangeSighting("warm", float(k), 2.0, 0.1, 0.1, 0.1))
        ekf.see(RangeSighting("warm-too", float(k), 2.0, 0.1))
    ekf.own_map()


def _warm_up_batch() -> None:
    """Solve a small graph of ranges, one of its tags without bearings."""
    graph = TagGraph(AgentConfig(), Pose2(), 0.0, None)
    here = GaussianPose(Pose2(), np.eye(3) * 1e-4)
    for turn in range(6):
        graph.add_pose(GaussianPose(Pose2(1.0, 0.0, 0.9), np.eye(3) * 1e-4), float(turn), None)
        x, y = graph.poses[-1].inverse().transform_point(2.0, 3.0)
        graph.add_range(RangeSighting("warm", float(turn), float(np.hypot(x, y)), 0.1), here)
        graph.add_range(RangeSighting("warm-too", float(turn), 1.0, 0.1, 0.1, 0.1), here)
    smooth_radio(graph.report(), AgentConfig())


def _warm_up_loops(scan: LaserScan) -> None:
    """Match a place with itself, as loops do: they come late in a mission, and then at once."""
    points = scan_points(scan, scan.range_max_m)
    cloud = Cloud(points.points, points.normals)
    match_clouds(cloud, cloud, Pose2(0.1, 0.0, 0.1), Window(0.5, radians(20.0)))
    match_clouds(cloud, cloud, Pose2(), Window(0.5, pi))
    share_seen_through(scan, Pose2(), points.points)


def _warm_up_bad_starts() -> None:
    """Solve a small loop from a start that is in doubt, and one with a wrong loop.

    Those kernels are needed rarely, and then at once.
    """
    graph = TagGraph(AgentConfig(), Pose2(), 0.0, None)
    for turn in range(4):
        graph.add_pose(GaussianPose(Pose2(1.0, 0.0, radians(90.0)), np.eye(3) * 1e-2), float(turn), None)
        graph.add_sighting(f"warm-{turn % 2}", (0.0, 0.0), np.eye(2) * 1e-2)
    solve(graph_problem(graph.report()), start="relaxed")
    graph.add_loop(0, 3, GaussianPose(Pose2(3.0, 4.0, 1.0), np.eye(3) * 1e-4))  # wrong
    solve(graph_problem(graph.report()))
