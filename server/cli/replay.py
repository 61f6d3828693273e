"""`waymark replay`: what real robots recorded through the same agents, here or on a server."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table, progress
from server.cli.options import JsonOption, OutOption, check_writable, finite

if TYPE_CHECKING:
    from robots.datasets.mission_log import UpdateComparison
    from robots.datasets.recording import Recording
    from robots.datasets.replay import RobotReplay
    from robots.team import TeamUpdate
    from robots.trajectory import Trajectory

_SLAM = ("tag-graph", "ekf", "rslam", "odometry")
_MEMORY = ("none", "tags")


def replay(
    dataset: Annotated[
        str,
        typer.Argument(
            metavar="DATASET",
            help="Format of the recording: csail, intel, mrclam; plaza, a folder; log, a mission that waymark"
            " export wrote; g2o, a pose graph.",
        ),
    ],
    path: Annotated[Path, typer.Argument(metavar="FILE", help="The recording.")],
    slam: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(_SLAM),
            help="odometry: dead reckoning and scan matching alone; tags are noted, the graph is not solved."
            " ekf: a filter over tags seen from afar. rslam: particles, by ranges alone. tag-graph, unless"
            " the recording says otherwise.",
        ),
    ] = None,
    robots: Annotated[
        str | None, typer.Option(metavar="N|r1,r3", help="Only the first N robots, or only these.")
    ] = None,
    order: Annotated[
        str | None,
        typer.Option(
            metavar="r3,r1", help="In which order the robots go through the recording, one after the other."
        ),
    ] = None,
    memory: Annotated[
        str,
        typer.Option(
            metavar="|".join(_MEMORY),
            help="tags: they keep the maps that robots leave in them, for those that come later in --order.",
        ),
    ] = "none",
    robot_sightings: Annotated[
        bool,
        typer.Option("--robot-sightings/--no-robot-sightings", help="Whether the robots see each other."),
    ] = True,
    virtual_tags: Annotated[
        float | None,
        typer.Option(
            metavar="D", help="Put a tag on the reference path wherever none is nearer than D metres."
        ),
    ] = None,
    range_only: Annotated[
        bool,
        typer.Option(
            "--range-only", help="mrclam: leave the bearings out; rslam, unless --slam says otherwise."
        ),
    ] = False,
    relations: Annotated[
        Path | None, typer.Option(metavar="FILE.relations", help="Compare with checked relations as well.")
    ] = None,
    out: OutOption = None,
    server: Annotated[
        str | None, typer.Option(metavar="URL", help="Post to this mission control instead of running here.")
    ] = None,
    speed: Annotated[
        float,
        typer.Option(metavar="N", help="With --server: N times as fast as recorded; 0: as fast as it goes."),
    ] = 1.0,
    mission: Annotated[
        str | None, typer.Option(metavar="ID", help="With --server: mission to post to, or to go on with.")
    ] = None,
    json: JsonOption = False,
) -> None:
    """Run the agents over a recording and say how well they did."""
    from robots.datasets.recording import RecordingError
    from robots.datasets.registry import load
    from robots.datasets.selection import choose_robots

    if virtual_tags is not None:
        finite("--virtual-tags", virtual_tags, above=0.0)
    finite("--speed", speed, at_least=0.0)
    if server is not None and (out is not None or relations is not None):
        raise CommandError("--out and --relations belong to a replay without --server; leave them out")
    if slam is not None and slam not in _SLAM:
        raise CommandError(f"--slam has to be {', '.join(_SLAM[:-1])} or {_SLAM[-1]}, not {slam!r}")
    if memory not in _MEMORY:
        raise CommandError(f"--memory has to be {' or '.join(_MEMORY)}, not {memory!r}")
    if server is not None and (memory != "none" or not robot_sightings):
        raise CommandError(
            "--memory and --no-robot-sightings belong to a replay without --server; leave them out"
        )
    changes = {} if slam is None else {"slam": slam}
    check_writable(out)
    if dataset == "g2o":
        from server.cli.replay_graph import replay_pose_graph

        given = (robots, order, virtual_tags, relations, server, mission)
        if any(option is not None for option in given) or memory != "none" or not robot_sightings:
            raise CommandError(
                "a pose graph has no robots and no sensors: it takes --slam, --out and --json alone"
            )
        _print(f"g2o {path.name}", replay_pose_graph(path, slam, out), json)
        return
    try:
        recording = load(dataset, path, virtual_tags)
        if range_only:
            recording = _without_bearings(recording)
        chosen = choose_robots(recording.robots, robots, order)
        if server is None:
            summary = _replay_here(
                recording, chosen, changes, relations, out, memory == "tags", robot_sightings
            )
        else:
            from server.cli.posting import post_recording

            summary = post_recording(recording, server, speed, mission, chosen, changes)
    except RecordingError as error:
        raise CommandError(str(error)) from error
    _print(f"{dataset} {path.name}", summary, json)


def _without_bearings(recording: Recording) -> Recording:
    from robots.datasets.mrclam import MrclamRecording

    if not isinstance(recording, MrclamRecording):
        raise CommandError("--range-only drops the bearings of mrclam; this recording has none")
    return replace(recording, range_only=True)


def _print(title: str, summary: dict[str, Any], json: bool) -> None:
    if json:
        print_json(summary)
    else:
        print_table(title, summary)


def _replay_here(
    recording: Recording,
    robots: tuple[str, ...],
    changes: dict[str, Any],
    relations: Path | None,
    out: Path | None,
    memory: bool = False,
    robot_sightings: bool = True,
) -> dict[str, Any]:
    import numpy as np

    from robots.agent import ObservationError
    from robots.config import ConfigError
    from robots.datasets.replay import replay as run
    from robots.estimation.graph.solve import GraphError
    from robots.evaluation import EvaluationError, read_relations
    from robots.outputs import write_team, write_trajectories

    try:
        pairs = read_relations(relations) if relations is not None else None
    except EvaluationError as error:
        raise CommandError(str(error)) from error
    began = perf_counter()
    with progress() as display:
        total = sum(recording.length(robot_id) for robot_id in robots)
        task = display.add_task(f"replaying {recording.name}", total=total)
        comparisons = {} if memory or not robot_sightings else _comparisons(recording, changes)
        try:
            result = run(
                recording,
                lambda: display.advance(task),
                robots,
                changes,
                lambda robot_id, update: comparisons[robot_id].take(update) if comparisons else None,
                memory,
                robot_sightings,
            )
        except (ConfigError, GraphError, ObservationError) as error:
            raise CommandError(f"{recording.name}: {error}") from error
    wall_s = perf_counter() - began
    if out is not None:
        for robot in result.robots:
            write_trajectories(out, robot.robot_id, robot.online, robot.final)
        write_team(out, result.team)
    step_ms = 1e3 * np.concatenate([robot.step_s for robot in result.robots])
    summary: dict[str, Any] = {
        "dataset": recording.name,
        "slam": changes.get("slam", recording.settings_of(robots[0]).get("slam", _SLAM[0])),
        "robots": len(result.robots),
        "observations": sum(robot.observations for robot in result.robots),
        "refused": sum(robot.refused for robot in result.robots),
        "distance_m": sum(robot.distance_m for robot in result.robots),
        "tags": len(result.team.tags),
        "sightings": sum(robot.sightings for robot in result.robots),
        "explored_m2": result.team.explored_m2,
        "ate_m": {robot.robot_id: _error_m(recording, robot, robot.final) for robot in result.robots},
        "ate_online_m": {robot.robot_id: _error_m(recording, robot, robot.online) for robot in result.robots},
        "tags_m": _tags_m(recording, result.team),
        "step_hz": len(step_ms) / wall_s,
        "wall_s": wall_s,
        "step_ms_p50": float(np.percentile(step_ms, 50)),
        "step_ms_p99": float(np.percentile(step_ms, 99)),
        "out": str(out) if out is not None else None,
    }
    if pairs is not None:
        summary["relations_m"] = {robot.robot_id: _relations_m(robot.final, pairs) for robot in result.robots}
        summary["relations_online_m"] = {
            robot.robot_id: _relations_m(robot.online, pairs) for robot in result.robots
        }
    if comparisons:
        summary["bit_equal"] = {robot_id: comparisons[robot_id].bit_equal() for robot_id in robots}
        summary["updates_compared"] = {robot_id: comparisons[robot_id].compared for robot_id in robots}
    return summary


def _comparisons(recording: Recording, changes: dict[str, Any]) -> dict[str, UpdateComparison]:
    """Return one for each robot of a mission log; none where agents are told other than they were."""
    from robots.datasets.mission_log import MissionLog, UpdateComparison

    if changes or not isinstance(recording, MissionLog):
        return {}
    return {robot_id: UpdateComparison(robot) for robot_id, robot in recording.logged.items()}


def _error_m(recording: Recording, robot: RobotReplay, estimate: Trajectory) -> float | None:
    from robots.evaluation import EvaluationError, absolute_error

    truth = recording.truth(robot.robot_id)
    if truth is None:
        return None
    try:
        return absolute_error(estimate, truth, max_gap_s=recording.truth_gap_s).rmse_m
    except EvaluationError:
        return None


def _tags_m(recording: Recording, team: TeamUpdate) -> float | None:
    from robots.evaluation import EvaluationError, places_error

    try:
        found = {tag.tag_id: (tag.x_m, tag.y_m) for tag in team.tags}
        return places_error(found, recording.tag_places()).mean_m
    except EvaluationError:
        return None


def _relations_m(estimate: Trajectory, pairs: Any) -> float:
    from robots.evaluation import EvaluationError, relations_error

    try:
        return relations_error(estimate, pairs).mean_m
    except EvaluationError as error:
        raise CommandError(f"--relations: {error}") from error
