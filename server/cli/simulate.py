"""`waymark simulate`: a simulated mission in one process, as fast as the machine allows."""

from __future__ import annotations

from enum import StrEnum
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from server.cli.console import CommandError, print_json, print_table, progress
from server.cli.options import (
    TAGS_PANEL,
    CommunicationOption,
    CoordinateOption,
    EnvironmentOption,
    ExploreOption,
    JsonOption,
    Memory,
    MemoryOption,
    OutOption,
    RadioRangeOption,
    SlamOption,
    TagBitsOption,
    Tags,
    TagsInPlaceOption,
    TagsOption,
    check_writable,
    finite,
)

if TYPE_CHECKING:
    from robots.sim.runner import SimulationResult
    from robots.sim.scenario import ScenarioConfig


class Poses(StrEnum):
    """How the robots know where they are."""

    SLAM = "slam"
    TRUTH = "truth"


class Start(StrEnum):
    """Where the robots begin."""

    SAME = "same"
    SPREAD = "spread"


def _count(help_text: str) -> Any:
    return typer.Option(metavar="N", help=help_text, rich_help_panel="Hostile world")


def _sensor(metavar: str, help_text: str) -> Any:
    return typer.Option(metavar=metavar, help=help_text, rich_help_panel="Sensors")


def simulate(
    map_spec: Annotated[str, typer.Option("--map", metavar="FILE.yaml|office:AREA|open:AREA")] = "office:300",
    robots: Annotated[int, typer.Option(metavar="N", help="Robots in the team.")] = 4,
    minutes: Annotated[float, typer.Option(metavar="M", help="Length of the mission.")] = 20.0,
    seed: Annotated[int, typer.Option(metavar="S", help="The same seed gives the same mission.")] = 0,
    poses: Annotated[Poses, typer.Option(help="Estimated, or given exactly.")] = Poses.SLAM,
    noise: Annotated[int, typer.Option(metavar="0-5", help="Noise level of the wheels.")] = 3,
    slip: Annotated[bool, typer.Option("--slip", help="Slippery patches on the floor.")] = False,
    victims: Annotated[int, typer.Option(metavar="N", help="People to be found.")] = 4,
    start: Annotated[Start, typer.Option(help="All at one place, or spread over the building.")] = Start.SAME,
    explore: ExploreOption = "waymark",
    local_map: Annotated[
        float, typer.Option(metavar="METRES", help="Plan on a square that goes along; 0: on the whole map.")
    ] = 0.0,
    coordinate: CoordinateOption = "none",
    communication: CommunicationOption = "tags",
    radio_range: RadioRangeOption = 20.0,
    radio_cut: Annotated[
        list[str] | None, typer.Option(metavar="ROBOT:FROM:TO", help="Silence in seconds; may be repeated.")
    ] = None,
    glass: Annotated[int, _count("Stretches of glass wall.")] = 0,
    bricks: Annotated[int, _count("Bricks below the laser's plane.")] = 0,
    smoke: Annotated[int, _count("Clouds of smoke.")] = 0,
    ramps: Annotated[int, _count("Ramps.")] = 0,
    fires: Annotated[int, _count("Fires that start and grow.")] = 0,
    dead_tags: Annotated[int, _count("Tags in place whose radio is dead,")] = 0,
    switched_tags: Annotated[int, _count("is off for a while,")] = 0,
    moved_tags: Annotated[int, _count("that are carried off,")] = 0,
    knocked_tags: Annotated[int, _count("that are knocked over,")] = 0,
    twin_tags: Annotated[int, _count("whose id another bears too.")] = 0,
    spikes: Annotated[int, _count("Of a thousand readings of a radio that are far off.")] = 0,
    tags: TagsOption = Tags.NEAR,
    environment: EnvironmentOption = "open",
    radio: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.yaml",
            help="In place of an environment: the radio that waymark fit-radio measured.",
            rich_help_panel=TAGS_PANEL,
        ),
    ] = None,
    tags_in_place: TagsInPlaceOption = 0,
    slam: SlamOption = None,
    memory: MemoryOption = Memory.NONE,
    tag_bits: TagBitsOption = None,
    laser_beams: Annotated[int, _sensor("N", "Beams of the laser.")] = 240,
    laser_range: Annotated[float, _sensor("METRES", "Range of the laser.")] = 4.0,
    laser_view: Annotated[float, _sensor("DEGREES", "Field of view of the laser.")] = 240.0,
    laser_hz: Annotated[float, _sensor("HZ", "Scans a second.")] = 5.0,
    sonars: Annotated[
        int, typer.Option(metavar="N", help="Sonars round the robot.", rich_help_panel="Sensors")
    ] = 0,
    infrareds: Annotated[
        int, typer.Option(metavar="N", help="Infrared rangers round the robot.", rich_help_panel="Sensors")
    ] = 0,
    no_imu: Annotated[
        bool, typer.Option("--no-imu", help="No heading from an IMU.", rich_help_panel="Sensors")
    ] = False,
    compass_off: Annotated[
        float,
        typer.Option(
            metavar="DEGREES",
            help="Each compass is off by a constant of its own, up to so much.",
            rich_help_panel="Sensors",
        ),
    ] = 0.0,
    out: OutOption = None,
    json: JsonOption = False,
) -> None:
    """Let a team of simulated robots explore a building, and say how it went.

    Step times are those of steps with a laser scan; step_hz counts all steps over the whole run.
    """
    from robots.config import MAX_LOCAL_MAP_M, AgentConfig, PlanningConfig
    from robots.datasets.radio_file import read_radio
    from robots.datasets.recording import RecordingError
    from robots.sim.arguments import parse_radio_cut
    from robots.sim.hostile import HostileConfig
    from robots.sim.per_robot import ScenarioError, parse_pairs
    from robots.sim.scenario import ScenarioConfig
    from robots.sim.sensors import LaserConfig
    from robots.sim.world import WorldError

    finite("--minutes", minutes, above=0.0)
    if not 0.0 <= local_map <= MAX_LOCAL_MAP_M:
        raise CommandError(f"--local-map {local_map:g} is out of range; give 0 to {MAX_LOCAL_MAP_M:g} metres")
    check_writable(out)
    try:
        config = ScenarioConfig(
            map=map_spec,
            robots=robots,
            minutes=minutes,
            seed=seed,
            poses=poses.value,
            slip=slip,
            noise_level=noise,
            victims=victims,
            start=start.value,
            radio_cuts=tuple(parse_radio_cut(text) for text in radio_cut or ()),
            hostile=HostileConfig(
                glass=glass,
                bricks=bricks,
                smoke=smoke,
                ramps=ramps,
                spikes=spikes,
                dead_tags=dead_tags,
                switched_tags=switched_tags,
                moved_tags=moved_tags,
                knocked_tags=knocked_tags,
                twin_tags=twin_tags,
                fires=fires,
            ),
            laser=LaserConfig(radians(laser_view), laser_beams, laser_range),
            laser_hz=laser_hz,
            imu=not no_imu,
            compass_off_rad=radians(compass_off),
            sonars=sonars,
            infrareds=infrareds,
            tags=tags.value,
            environment=environment,
            measured_radio=None if radio is None else read_radio(radio),
            tags_in_place=tags_in_place,
            slam=parse_pairs("slam", slam) if slam else (),
            explore=parse_pairs("explore", explore),
            coordinate=parse_pairs("coordinate", coordinate),
            communication=parse_pairs("communication", communication),
            tag_bits=tag_bits,
            team_radio_m=radio_range,
            agent_config=AgentConfig(
                planning=PlanningConfig(local_map_m=local_map), map_memory=memory is Memory.TAGS
            ),
        )
        _warn_of_deaf_robots(config)
        outcome = play(config)
    except (ScenarioError, WorldError, RecordingError) as error:
        raise CommandError(str(error)) from error
    summary = report(outcome, out)
    if json:
        print_json(summary)
    else:
        print_table(f"{robots} robots, {minutes:g} minutes in {map_spec}", summary)


def _warn_of_deaf_robots(config: ScenarioConfig) -> None:
    from robots.exploration.methods import hears_nobody

    told = [config.agent_of(robot_id).planning for robot_id in config.robot_ids]
    for deaf in sorted({hears_nobody(each.coordinate, each.communication) for each in told} - {""}):
        typer.echo(f"Note: {deaf} (--communication).", err=True)


def play(config: ScenarioConfig) -> SimulationResult:
    """Play the scenario behind a progress bar."""
    from robots.sim.runner import run

    with progress() as display:
        task = display.add_task("simulating", total=config.periods)
        return run(config, progress=lambda _: display.advance(task))


def report(outcome: SimulationResult, out: Path | None) -> dict[str, Any]:
    """Return the summary of a mission, and write its files where a folder is given."""
    import numpy as np

    from robots.sim.solution import solve

    solution = solve(outcome)
    if out is not None:
        solution.write(out)
    score = outcome.score
    scan_ms = 1e3 * np.concatenate([robot.steps_s[robot.with_scan] for robot in outcome.robots])
    steps = sum(len(robot.steps_s) for robot in outcome.robots)
    return {
        "explored_m2": score.explored_m2,
        "observable_m2": score.observable_m2,
        "coverage": score.coverage,
        "covered_s": {f"{share:.0%}": clock_s for share, clock_s in outcome.covered_s.items()},
        "known_at_base": outcome.known_at_base,
        "distance_m": score.distance_m,
        "score": score.score_m,
        "victims_found": score.victims_found,
        "victims_total": score.victims_total,
        "tags_dropped": outcome.tags_dropped,
        "ate_m": solution.ate_m(),
        "step_hz": steps / outcome.wall_s,
        "wall_s": outcome.wall_s,
        "step_ms_p50": float(np.percentile(scan_ms, 50)) if len(scan_ms) else None,
        "step_ms_p99": float(np.percentile(scan_ms, 99)) if len(scan_ms) else None,
        "steps": steps,
        "simulated_s": outcome.clock_s,
        "times_real_time": outcome.clock_s / outcome.wall_s,
        "out": str(out) if out is not None else None,
    }
