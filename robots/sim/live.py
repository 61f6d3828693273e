"""Live missions: a scenario whose robots reach the server only through the robot API, in lockstep.

Every control period each robot posts its observations, all at once and each over its own connection; when
every reply is there the orders are applied in the order of the team, so the outcome does not depend on who
was answered first.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, is_dataclass, replace
from math import inf
from threading import Event
from typing import Any

from robots.agent import RobotAgent, merge_commands
from robots.client import ClientError, RobotClient
from robots.config import AgentConfig
from robots.orders import RobotOrder
from robots.sim.arguments import add_scenario_arguments, scenario_from_arguments
from robots.sim.pilots import Agent, AgentFactory, Merge, Pilot
from robots.sim.responder import Responder
from robots.sim.runner import mission_score, radio
from robots.sim.scenario import START_SD_M, START_SD_RAD, RadioCut, ScenarioConfig, ScenarioError, is_cut
from robots.sim.score import Score
from robots.sim.simulation import Order, Simulation
from robots.sim.wire import (
    Json,
    command_from_wire,
    command_to_wire,
    observation_to_wire,
    order_from_wire,
    pose_to_wire,
)
from robots.sim.world import WorldError
from robots.types import Command, Observation

_BEHIND_S = 1.0  # a mission that falls further behind its clock does not hurry after it


class LiveError(Exception):
    """The mission cannot be played on this server; the message says why."""


@dataclass(frozen=True, slots=True)
class LiveResult:
    """How far a live mission came; the score counts no victims, which are the server's to tell."""

    clock_s: float
    wall_s: float
    score: Score
    stopped: bool


class ServerPilot:
    """An agent behind the robot API."""

    def __init__(self, client: RobotClient) -> None:
        self._client = client

    def decide(self, observations: Sequence[Observation], clock_s: float) -> Order:
        """Post the batch; the reply is the order."""
        reply = self._client.post([observation_to_wire(observation) for observation in observations])
        return Order(command_from_wire(reply["command"]), held=bool(reply["stop"]))


class OnboardPilot:
    """An agent on board, which decides alone and tells the server when the radio lets it."""

    def __init__(self, agent: Agent, merge: Merge, client: RobotClient, cuts: Sequence[RadioCut]) -> None:
        self._agent = agent
        self._merge = merge
        self._client = client
        self._cuts = tuple(cuts)
        self._stopped = False
        self._orders: dict[str, RobotOrder] = {}  # told and not taken yet

    def decide(self, observations: Sequence[Observation], clock_s: float) -> Order:
        """Step the agent; post what it saw and decided, or keep it for later.

        A STOP holds until it is taken back.
        """
        *before, last = observations
        observations = (*before, replace(last, orders=tuple(self._orders.values())))
        self._orders = {}
        updates = [self._agent.step(observation) for observation in observations]
        self._client.keep(
            [observation_to_wire(observation) for observation in observations],
            [
                {
                    "seq": update.seq,
                    "pose": pose_to_wire(update.pose),
                    "command": command_to_wire(update.command),
                }
                for update in updates
            ],
        )
        if not is_cut(self._cuts, clock_s):
            try:
                reply = self._client.post()
                self._stopped = bool(reply["stop"])
                self._orders = {order["order_id"]: order_from_wire(order) for order in reply["orders"]}
            except ClientError as error:
                if error.code != "unreachable":  # out of reach is radio silence too
                    raise
        return Order(self._merge(updates) if not self._stopped else Command(), held=self._stopped)


def play(
    config: ScenarioConfig,
    url: str,
    mission_id: str,
    *,
    name: str | None = None,
    speed: float = 1.0,
    stop: Event | None = None,
    progress: Callable[[Simulation], None] | None = None,
    agent_factory: AgentFactory = RobotAgent,
    merge: Merge = merge_commands,
    client_type: type[RobotClient] = RobotClient,
    responder: str = "",
) -> LiveResult:
    """Play a scenario on a server, ``speed`` times as fast as real time (0: as fast as it answers).

    ``responder``: the name of somebody who walks to the victims that are found, where nobody has to log in.
    Waits for a server that is away and sends again. Ends early when ``stop`` is set, from any thread.

    Raises:
        LiveError: the mission has these robots already, with observations.
        ClientError: the server refused.
        WorldError, ScenarioError: the scenario cannot be played.
    """
    stop = stop or Event()
    began = time.monotonic()
    simulation = Simulation(config)
    clients = {
        robot_id: client_type(url, mission_id, robot_id, patience_s=inf) for robot_id in config.robot_ids
    }
    with ThreadPoolExecutor(config.robots + 1, "robot") as threads:
        ended = Event()
        threads.submit(_close_on, stop, ended, clients)
        try:
            _register(simulation, clients, name or mission_id)
            if config.agent == "onboard":
                for client in clients.values():
                    client.patience_s = 0.0  # an agent on board does not wait for the server
            pilots = {
                robot_id: _pilot(simulation, robot_id, client, agent_factory, merge)
                for robot_id, client in clients.items()
            }
            if responder:
                Responder(simulation, url, mission_id, responder, speed, ended).start()
            _play(simulation, pilots, threads, speed, stop, progress)
        except ClientError as error:
            if error.code != "closed":
                raise
        finally:
            ended.set()
            for client in clients.values():
                client.close()
    return LiveResult(
        simulation.clock_s, time.monotonic() - began, mission_score(simulation, ()), stop.is_set()
    )


def _play(
    simulation: Simulation,
    pilots: dict[str, Pilot],
    threads: ThreadPoolExecutor,
    speed: float,
    stop: Event,
    progress: Callable[[Simulation], None] | None,
) -> None:
    due = time.monotonic()
    for _ in range(simulation.config.periods):
        if stop.is_set():
            return
        batches = simulation.advance()
        clock_s = simulation.clock_s
        replies = {
            name: threads.submit(pilots[name].decide, batch, clock_s) for name, batch in batches.items()
        }
        simulation.apply({name: reply.result() for name, reply in replies.items()})
        if progress is not None:
            progress(simulation)
        if speed > 0.0:
            due = max(due + simulation.config.period_s / speed, time.monotonic() - _BEHIND_S)
            stop.wait(max(0.0, due - time.monotonic()))


def _close_on(stop: Event, ended: Event, clients: dict[str, RobotClient]) -> None:
    """Close the clients as soon as the mission is to stop, so that nobody keeps waiting for a server."""
    while not ended.is_set():
        if stop.wait(0.1):
            for client in clients.values():
                client.close()
            return


def _register(simulation: Simulation, clients: dict[str, RobotClient], name: str) -> None:
    config = simulation.config
    next(iter(clients.values())).create_mission(name, config.agent_config.tag_memory.key)
    for start, (robot_id, client) in zip(simulation.starts, clients.items(), strict=True):
        reply = client.register(
            agent=config.agent,
            start_pose={**pose_to_wire(start), "sd_m": START_SD_M, "sd_rad": START_SD_RAD},
            silence={"after_s": config.silence.after_s, "policy": config.silence.policy},
            config=changes(config.agent_of(robot_id), AgentConfig()),
        )
        if reply["next_seq"] > 0:
            raise LiveError(
                f"robot {robot_id} has observations in this mission already; play in a new mission"
            )


def _pilot(
    simulation: Simulation, robot_id: str, client: RobotClient, agent_factory: AgentFactory, merge: Merge
) -> Pilot:
    config = simulation.config
    if config.agent == "server":
        return radio(config, robot_id, ServerPilot(client))
    cuts = [cut for cut in config.radio_cuts if cut.robot_id == robot_id]
    return OnboardPilot(agent_factory(robot_id, simulation.agent_of(robot_id)), merge, client, cuts)


def changes(config: Any, default: Any) -> Json:
    """Return what differs between nested settings, as the nested object ``override`` takes."""
    different: Json = {}
    for item in fields(config):
        value, usual = getattr(config, item.name), getattr(default, item.name)
        if value == usual:
            continue
        different[item.name] = changes(value, usual) if is_dataclass(value) else value
    return different


def main(argv: Sequence[str] | None = None) -> int:
    """Play a scenario on a server until Ctrl-C or SIGTERM ends it; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m robots.sim.live", description="Play a scenario live on a server."
    )
    parser.add_argument("--url", default="http://127.0.0.1:8000", help="address of mission control")
    parser.add_argument("--mission", required=True, help="mission id; created where it does not exist")
    parser.add_argument("--name", help="the mission's name on screen")
    parser.add_argument("--responder", default="", help="name of somebody who walks to the victims found")
    parser.add_argument("--speed", type=float, default=1.0, help="times real time; 0: as fast as it answers")
    add_scenario_arguments(parser)
    arguments = parser.parse_args(argv)
    stop = Event()
    before = {
        number: signal.signal(number, lambda *_: stop.set()) for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        config = scenario_from_arguments(arguments)
        result = play(
            config,
            arguments.url,
            arguments.mission,
            name=arguments.name,
            speed=arguments.speed,
            stop=stop,
            responder=arguments.responder,
        )
    except (ScenarioError, WorldError, LiveError, ClientError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    score = result.score
    print(
        f"{result.clock_s:.0f} s played, {score.explored_m2:.0f} of {score.observable_m2:.0f} m2 seen"
        f" ({100.0 * score.coverage:.0f} %), {score.distance_m:.0f} m driven"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
