"""Who leads a robot: an agent in this process, or one behind the robot API.

Both answer a batch with one order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

from robots.client import MAX_BATCH
from robots.config import AgentConfig
from robots.sim.scenario import RadioCut, SilenceConfig, is_cut
from robots.sim.simulation import Order
from robots.types import AgentUpdate, Command, Observation


class Agent(Protocol):
    """What the simulator asks of an agent; ``robots.agent.RobotAgent`` is one."""

    def step(self, observation: Observation) -> AgentUpdate:
        """Return what the agent makes of one observation."""

    def smoothed(self) -> AgentUpdate:
        """Return the latest update with all submaps, all victims and the graph after a batch solve."""


AgentFactory = Callable[[str, AgentConfig], Agent]
Merge = Callable[[Sequence[AgentUpdate]], Command]


class Pilot(Protocol):
    """Leads one robot."""

    def decide(self, observations: Sequence[Observation], clock_s: float) -> Order:
        """Return the order for the next period, given the observations up to now."""


class DirectPilot:
    """Steps an agent in this process. ``on_update`` sees every observation with its update, in order."""

    def __init__(
        self, agent: Agent, merge: Merge, on_update: Callable[[Observation, AgentUpdate], None] | None = None
    ) -> None:
        self._agent = agent
        self._merge = merge
        self._on_update = on_update

    def decide(self, observations: Sequence[Observation], clock_s: float) -> Order:
        """Step the agent through the batch and merge its commands."""
        updates = []
        for observation in observations:
            update = self._agent.step(observation)
            updates.append(update)
            if self._on_update is not None:
                self._on_update(observation, update)
        return Order(self._merge(updates))


class RadioPilot:
    """A pilot at the far end of a radio that is cut now and then.

    In silence the robot keeps its last velocities and then follows its policy; what it observed meanwhile
    arrives as a backlog, in batches as large as the API takes, and the reply to the last of them is its next
    order.
    """

    def __init__(self, inner: Pilot, cuts: Sequence[RadioCut], silence: SilenceConfig) -> None:
        self._inner = inner
        self._cuts = tuple(cuts)
        self._silence = silence
        self._backlog: list[Observation] = []
        self._last = Order()
        self._heard_s = 0.0

    def decide(self, observations: Sequence[Observation], clock_s: float) -> Order:
        """Pass the batch on, or follow the policy while the radio is cut."""
        self._backlog.extend(observations)
        if is_cut(self._cuts, clock_s):
            if self._silence.policy == "hold" and clock_s - self._heard_s >= self._silence.after_s:
                return Order(Command(), held=True)
            return replace(
                self._last, command=replace(self._last.command, drop_tag=False, writes=(), say=None)
            )
        for start in range(0, len(self._backlog), MAX_BATCH):
            self._last = self._inner.decide(self._backlog[start : start + MAX_BATCH], clock_s)
        self._backlog = []
        self._heard_s = clock_s
        return self._last
