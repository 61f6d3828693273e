"""`waymark demo`: mission control with a simulated team at work, in one go."""

from __future__ import annotations

import argparse
import secrets
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from server.cli.options import (
    CommunicationOption,
    CoordinateOption,
    EnvironmentOption,
    ExploreOption,
    Memory,
    MemoryOption,
    SlamOption,
    Tags,
    TagsInPlaceOption,
    TagsOption,
    finite,
)
from server.cli.serve import DataOption, HostOption, PortOption, make_settings, run_server


def demo(
    robots: Annotated[int, typer.Option(metavar="N", help="Robots in the team.")] = 4,
    map_spec: Annotated[str, typer.Option("--map", metavar="FILE.yaml|office:AREA|open:AREA")] = "office:300",
    victims: Annotated[int, typer.Option(metavar="N", help="People to be found.")] = 4,
    minutes: Annotated[float, typer.Option(metavar="M", help="Length of the mission.")] = 60.0,
    seed: Annotated[int, typer.Option(metavar="S", help="The same seed gives the same building.")] = 7,
    speed: Annotated[float, typer.Option(metavar="N", help="Times real time.")] = 1.0,
    tags: TagsOption = Tags.NEAR,
    environment: EnvironmentOption = "open",
    tags_in_place: TagsInPlaceOption = 0,
    slam: SlamOption = None,
    memory: MemoryOption = Memory.NONE,
    explore: ExploreOption = "waymark",
    coordinate: CoordinateOption = "none",
    communication: CommunicationOption = "tags",
    fires: Annotated[int, typer.Option(metavar="N", help="Fires; active nodes near them tell.")] = 0,
    host: HostOption = None,
    port: PortOption = None,
    data: DataOption = None,
    open_browser: Annotated[bool, typer.Option("--open", help="Open it in the browser.")] = False,
) -> None:
    """Open a mission of simulated robots that explore a generated building, until Ctrl-C.

    Without --data, everything is forgotten at the end.
    """
    finite("--minutes", minutes, above=0.0)
    finite("--speed", speed, above=0.0)
    scenario = _checked_scenario(
        {
            "map": map_spec,
            "robots": robots,
            "minutes": minutes,
            "seed": seed,
            "victims": victims,
            "tags": tags.value,
            "environment": environment,
            "tags-in-place": tags_in_place,
            "memory": memory.value,
            "fires": fires,
            "explore": explore,
            "coordinate": coordinate,
            "communication": communication,
        }
        | ({"slam": slam} if slam else {})
    )
    with ExitStack() as stack:
        folder = data or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="waymark-demo-")))
        from server.settings import is_loopback

        settings = make_settings(
            host=host,
            port=port,
            data_dir=folder,
            database=str(folder / "waymark.db"),
            login="off" if host is None or is_loopback(host) else "on",
            robot_token=secrets.token_urlsafe(32),
        )
        from server.cli.team import SimulatedTeam

        mission = "demo" if data is None else f"demo-{int(time.time())}"
        arguments = ["--mission", mission, "--name", "Demonstration", "--speed", str(speed), *scenario]
        if settings.login == "off":  # where people log in, nobody can do so for them
            arguments += ["--responder", "Kim"]
        stack.enter_context(SimulatedTeam(settings, arguments, open_browser))
        run_server(settings)


def _checked_scenario(values: dict[str, object]) -> list[str]:
    """Return the scenario as arguments for the team's process, having made sure that it can be played."""
    from robots.sim.arguments import add_scenario_arguments, scenario_from_arguments
    from robots.sim.per_robot import ScenarioError
    from robots.sim.scenario import build_world
    from robots.sim.world import WorldError
    from server.cli.console import CommandError

    words = [word for name, value in values.items() for word in (f"--{name}", str(value))]
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_scenario_arguments(parser)
    try:
        build_world(scenario_from_arguments(parser.parse_args(words)))
    except (argparse.ArgumentError, ScenarioError, WorldError) as error:
        raise CommandError(str(error)) from error
    return words
