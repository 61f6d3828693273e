"""Signals of an exported mission with the distances that the robots' own maps tell.

Only tags that were read from above count: their places are known without any radio, so the fit does not find
again what an estimator assumed.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import hypot
from pathlib import Path

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.datasets import mission_log
from robots.datasets.recording import RecordingError
from robots.estimation.radio.fit import Collector, Signals
from robots.estimation.radio.model import RadioModel
from robots.graph_report import GraphReport
from robots.overrides import override
from robots.se2 import Pose2
from robots.types import Observation

Heard = tuple[int, Pose2, str, float]  # anchor, antenna from there, tag, dBm


def load_signals(path: Path) -> Signals:
    """Let the mission's agents go through the log again, and return what they heard, with distances.

    Raises:
        RecordingError: the log cannot be read, or no tag that was heard was read from above.
    """
    log = mission_log.load(path)
    collector = Collector()
    for robot_id in log.robots:
        config = override(AgentConfig(), log.settings_of(robot_id))
        collect(collector, robot_id, config, log.observations(robot_id))
    signals = collector.signals()
    if not len(signals.rssis_dbm):
        raise RecordingError(
            f"{path}: no tag that was heard by radio was also read from above, so nobody knows the distances"
        )
    return signals


def collect(
    collector: Collector, robot_id: str, config: AgentConfig, observations: Iterable[Observation]
) -> None:
    """Collect the signals that one robot heard of tags that it also read from above."""
    agent = RobotAgent(robot_id, config)
    model = RadioModel(config.radio)
    heard: list[Heard] = []
    for observation in observations:
        update = agent.step(observation)
        for sighting in observation.tag_sightings:
            if sighting.rssi_dbm is not None:
                antenna = update.anchor_from_base @ model.direction(sighting.antenna).base_from_antenna
                heard.append((update.anchor, antenna, sighting.tag_id, sighting.rssi_dbm))
    graph = agent.smoothed().graph if heard else None
    if graph is None:
        return
    known = _read_from_above(graph)
    for anchor, antenna, tag_id, rssi_dbm in heard:
        if tag_id in known:
            here = Pose2.from_array(graph.poses[anchor]) @ antenna
            x, y = known[tag_id]
            collector.add(f"{robot_id} {tag_id}", here.x, here.y, hypot(here.x - x, here.y - y), rssi_dbm)


def _read_from_above(graph: GraphReport) -> dict[str, tuple[float, float]]:
    chosen = sorted({int(tag) for tag in graph.sighting_pairs[:, 1]})
    return {graph.tag_ids[tag]: (float(graph.tags[tag, 0]), float(graph.tags[tag, 1])) for tag in chosen}
