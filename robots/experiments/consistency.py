"""Whether what is claimed holds: covariances against true errors, and tags told as wrong that are not.

Each run plays a mission of its own in a generated office; what the robots claim at its end, online, is held
against the simulator's truth. No figure of a paper stands beside it: Kleiner 2006 prints no covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.special import betaincinv

from robots.agent import RobotAgent
from robots.estimation.tag_graph.graph import solve_report
from robots.experiments import plotting
from robots.experiments.experiment import Column, Experiment, Options, Row, finite
from robots.experiments.parallel import in_parallel
from robots.graph_report import GraphReport
from robots.se2 import Array, Pose2, wrap
from robots.sim.runner import RobotResult, SimulationResult
from robots.sim.runner import run as play
from robots.sim.scenario import START_SD_M, START_SD_RAD, ScenarioConfig
from robots.team import StartPose, TeamMap, TeamUpdate
from robots.types import AgentUpdate

MISSIONS = (("office:150", 2), ("office:300", 3))
MINUTES, LEVEL = 4.0, 3
_BEYOND = 30.0  # of an NEES with 3 degrees of freedom: one in a million by chance
_SURE = 0.95


@dataclass(frozen=True, slots=True, eq=False)
class Claims:
    """What one mission claimed: NEES of displacements (d,), of the team's tags (t,), of graphs (g,).

    The last are e' P^-1 e of all tags of a robot together, a degree of freedom. ``alarms`` are tags told as
    moved, cloned or doubtful though none is; ``reread`` had a second sighting to contradict the first.
    """

    displacements: Array
    tags: Array
    graphs: Array
    alarms: int
    reread: int


class _Online(RobotAgent):
    """An agent whose map is asked for as it is: nothing is smoothed."""

    def smoothed(self) -> AgentUpdate:
        return self.report()


def run(options: Options, minutes: float = MINUTES) -> list[Row]:
    """Play missions; one row for each kind of them and one for all."""
    tasks = [
        (map_spec, robots, minutes, _seed(options.seed, number))
        for map_spec, robots in MISSIONS
        for number in range(options.runs)
    ]
    claims = in_parallel(measure, tasks, options.jobs, options.progress)
    rows = [
        row_of(map_spec, robots, claims[k * options.runs : (k + 1) * options.runs])
        for k, (map_spec, robots) in enumerate(MISSIONS)
    ]
    return [*rows, row_of("all", sum(robots for _, robots in MISSIONS), claims)]


def _seed(seed: int, number: int) -> int:
    return int(np.random.default_rng([seed, number, 11]).integers(2**31))


def measure(task: tuple[str, int, float, int]) -> Claims:
    """Play one mission: (map, robots, minutes, seed)."""
    map_spec, robots, minutes, seed = task
    config = ScenarioConfig(
        map=map_spec, robots=robots, minutes=minutes, seed=seed, noise_level=LEVEL, victims=0
    )
    result = play(config, _Online)
    team = TeamMap()
    for robot in result.robots:
        team.add_robot(robot.robot_id, StartPose(robot.start, START_SD_M, START_SD_RAD))
        team.put(robot.robot_id, robot.report)
    update = team.solve()
    return Claims(
        np.concatenate([displacement_nees(robot) for robot in result.robots]),
        _tag_nees(update, _places(result)),
        np.array([graph_nees(robot, result) for robot in result.robots]),
        sum(tag.state != "sound" for tag in update.tags),
        sum(tag.sightings > 1 for tag in update.tags),
    )


def displacement_nees(robot: RobotResult) -> Array:
    """Return the NEES, 3 degrees of freedom, of each displacement between anchors that follow each other."""
    graph = _graph(robot)
    at = np.searchsorted(robot.stamps_s, graph.stamps_s)
    true = [Pose2.from_array(row) for row in robot.truths[at]]
    found = []
    for (i, j), measured, covariance in zip(
        graph.edge_pairs, graph.edge_poses, graph.edge_covariances, strict=True
    ):
        driven, told = true[i].between(true[j]), Pose2.from_array(measured)
        error = driven.as_array() - told.as_array()
        error[2] = wrap(error[2])
        c, s = np.cos(told.theta), np.sin(told.theta)
        error[:2] = np.array([[c, s], [-s, c]]) @ error[:2]  # covariances of poses are in their own frame
        found.append(float(error @ np.linalg.solve(covariance, error)))
    return np.array(found)


def graph_nees(robot: RobotResult, result: SimulationResult) -> float:
    """Return e' P^-1 e of all tags a robot's own graph has, together, a degree of freedom."""
    graph, places = _graph(robot), _places(result)
    solution = solve_report(graph, result.config.agent_of(robot.robot_id).graph)
    map_from_world = robot.world_from_map.inverse()
    true = np.array([map_from_world.transform_point(*places[tag_id]) for tag_id in graph.tag_ids])
    count = len(graph.tag_ids)
    if not count:
        return float("nan")
    joint = solution.marginals.joint(len(solution.poses) + np.arange(count))
    kept = np.flatnonzero(np.arange(3 * count) % 3 < 2)
    error = (solution.tags - true).ravel()
    return float(error @ np.linalg.solve(joint[np.ix_(kept, kept)], error)) / (2 * count)


def _tag_nees(update: TeamUpdate, places: dict[str, tuple[float, float]]) -> Array:
    found = []
    for tag in update.tags:
        if tag.tag_id in places:
            error = np.array([tag.x_m, tag.y_m]) - places[tag.tag_id]
            found.append(float(error @ np.linalg.solve(tag.covariance, error)))
    return np.array(found)


def _places(result: SimulationResult) -> dict[str, tuple[float, float]]:
    return {tag.tag_id: (tag.x_m, tag.y_m) for tag in result.tags}


def _graph(robot: RobotResult) -> GraphReport:
    if robot.report.graph is None:
        raise RuntimeError("a report holds the whole graph")
    return robot.report.graph


def interval(count: int, total: int, sure: float = _SURE) -> tuple[float, float]:
    """Return the bounds of a rate of which ``count`` of ``total`` were seen (Clopper and Pearson 1934)."""
    tail = (1.0 - sure) / 2.0
    low = 0.0 if count == 0 else float(betaincinv(count, total - count + 1, tail))
    high = 1.0 if count == total else float(betaincinv(count + 1, total - count, 1.0 - tail))
    return low, high


def row_of(map_spec: str, robots: int, claims: Sequence[Claims]) -> Row:
    """Return the row of several missions."""
    displacements = np.concatenate([claim.displacements for claim in claims])
    tags, graphs = np.concatenate([c.tags for c in claims]), np.concatenate([c.graphs for c in claims])
    alarms = sum(claim.alarms for claim in claims)
    low, high = interval(alarms, max(len(tags), 1))
    return {
        "map": map_spec,
        "robots": robots,
        "missions": len(claims),
        "displacements": len(displacements),
        "displacement_nees": float(np.mean(displacements)),
        "displacement_nees_median": float(np.median(displacements)),
        "displacements_beyond_30": int((displacements > _BEYOND).sum()),
        "tags": len(tags),
        "tags_read_again": sum(claim.reread for claim in claims),
        "tag_nees": float(np.mean(tags)),
        "tag_nees_median": float(np.median(tags)),
        "joint_nees_per_dof": float(np.nanmean(graphs)),
        "joint_nees_per_dof_median": float(np.nanmedian(graphs)),
        "joint_nees_per_dof_worst": float(np.nanmax(graphs)),
        "false_alarms": alarms,
        "missions_with_false_alarms": sum(claim.alarms > 0 for claim in claims),
        "false_alarm_percent": 100.0 * alarms / max(len(tags), 1),
        "false_alarm_percent_low": 100.0 * low,
        "false_alarm_percent_high": 100.0 * high,
    }


def plot(rows: list[Row], path: Path) -> None:
    """Draw NEES a degree of freedom. Raises ExperimentError when the file cannot be written."""
    drawn = (
        ("displacement_nees_median", 2.37, "displacements (median)", plotting.BLUE),
        ("tag_nees_median", 1.39, "tags (median)", plotting.GREEN),
        ("joint_nees_per_dof_median", 1.0, "all tags together", plotting.ORANGE),
    )
    with plotting.figure(path, 1, 1, 6.0, 3.6, "True errors against claimed ones") as axes:
        panel, at = axes[0][0], np.arange(len(rows))
        for k, (name, expected, label, colour) in enumerate(drawn):
            heights = [finite(row, name) / expected for row in rows]
            panel.bar(at + 0.27 * (k - 1), heights, 0.25, label=label, color=colour)
        panel.axhline(1.0, color=plotting.BLACK, linewidth=0.8)
        panel.set_xticks(at, [str(row["map"]) for row in rows])
        panel.set_ylabel("of what was claimed (NEES)")
        panel.legend()


EXPERIMENT = Experiment(
    name="consistency",
    summary="Claimed covariances against true errors, and false alarms of tags, over simulated missions.",
    paper="none: Kleiner 2006 prints no covariance; NEES after Bar-Shalom et al. 2001",
    default_runs=10,
    run=run,
    plot=plot,
    columns=(
        Column("map", "map"),
        Column("missions", "missions"),
        Column("displacements", "displacements"),
        Column("NEES (3)", "displacement_nees"),
        Column("median (2.37)", "displacement_nees_median"),
        Column("beyond 30", "displacements_beyond_30"),
        Column("tags", "tags"),
        Column("NEES (2)", "tag_nees"),
        Column("median (1.39)", "tag_nees_median"),
        Column("joint / dof (1)", "joint_nees_per_dof"),
        Column("median", "joint_nees_per_dof_median"),
        Column("worst", "joint_nees_per_dof_worst"),
        Column("false alarms", "false_alarms"),
        Column("% low", "false_alarm_percent_low"),
        Column("% high", "false_alarm_percent_high"),
    ),
    notes=(
        f"{MINUTES:g} minutes at noise level {LEVEL}; in brackets what honest covariances give.",
        "Joint: all tags of one robot's graph together. False alarms: sound tags told as wrong, % of all,",
        "95 % interval (Clopper and Pearson), which takes tags of one mission for independent.",
    ),
)
