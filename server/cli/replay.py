"""`waymark replay`: what real robots recorded through the same agents, here or on a server."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table, progress
from server.cli.options import JsonOption, OutOption, check_writable, finite

if TYPE_CHECKING:
    from robots.datasets.recording import Recording
    from robots.datasets.replay import RobotReplay
    from robots.trajectory import Trajectory

_SLAM = ("tag-graph", "odometry")


def replay(
    dataset: Annotated[
        str,
        typer.Argument(
            metavar="DATASET",
            help="Format of the recording: csail, intel, mrclam; log, a mission that waymark export wrote;"
            " g2o, a pose graph.",
        ),
    ],
    path: Annotated[Path, typer.Argument(metavar="FILE", help="The recording.")],
    slam: Annotated[
        str | None,
        typer.Option(
            metavar="tag-graph|odometry",
            help="odometry: dead reckoning and scan matching alone; tags are noted, the graph is not solved."
            " tag-graph, unless the recording says otherwise.",
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
    virtual_tags: Annotated[
        float | None,
        typer.Option(
            metavar="D", help="Put a tag on the reference path wherever none is nearer than D metres."
        ),
    ] = None,
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
        raise CommandError(f"--slam has to be {' or '.join(_SLAM)}, not {slam!r}")
    changes = {} if slam is None else {"slam": slam}
    check_writable(out)
    try:
        recording = load(dataset, path, virtual_tags)
        chosen = choose_robots(recording.robots, robots, order)
        if server is None:
            summary = _replay_here(recording, chosen, changes, relations, out)
        else:
            from server.cli.posting import post_recording

            summary = post_recording(recording, server, speed, mission, chosen, changes)
    except RecordingError as error:
        raise CommandError(str(error)) from error
    if json:
        print_json(summary)
    else:
        print_table(f"{dataset} {path.name}", summary)


def _replay_here(
    recording: Recording,
    robots: tuple[str, ...],
    changes: dict[str, Any],
    relations: Path | None,
    out: Path | None,
) -> dict[str, Any]:
    import numpy as np

    from robots.agent import ObservationError
    from robots.config import ConfigError
    from robots.datasets.replay import replay as run
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
        try:
            result = run(recording, lambda: display.advance(task), robots, changes)
        except (ConfigError, ObservationError) as error:
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
    return summary


def _error_m(recording: Recording, robot: RobotReplay, estimate: Trajectory) -> float | None:
    from robots.evaluation import EvaluationError, absolute_error

    truth = recording.truth(robot.robot_id)
    if truth is None:
        return None
    try:
        return absolute_error(estimate, truth, max_gap_s=recording.truth_gap_s).rmse_m
    except EvaluationError:
        return None


def _relations_m(estimate: Trajectory, pairs: Any) -> float:
    from robots.evaluation import EvaluationError, relations_error

    try:
        return relations_error(estimate, pairs).mean_m
    except EvaluationError as error:
        raise CommandError(f"--relations: {error}") from error
