"""Posting a recording to a running mission control, as its robots would have done, at a chosen speed."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import Any

from robots.client import ClientError, RobotClient
from robots.datasets.recording import Recording
from robots.sim.wire import observation_to_wire, pose_to_wire
from robots.types import Observation
from server.cli.console import CommandError, progress, say

_BATCH = 50
_TOGETHER_S = 0.05  # observations that are due within so long of each other are posted together


def post_recording(
    recording: Recording,
    url: str,
    speed: float,
    mission_id: str | None,
    robots: Sequence[str],
    changes: dict[str, Any],
) -> dict[str, Any]:
    """Post the robots' observations, one robot after the other, and return a summary.

    ``changes`` are overrides of the agents' configuration beside the recording's own.

    Raises:
        CommandError: the server cannot be reached, or refuses.
    """
    mission_id = mission_id or f"{recording.name}-{int(time.time())}"
    began = time.monotonic()
    posted = 0
    try:
        for robot_id in robots:
            config = {**recording.settings_of(robot_id), **changes}
            posted += _post_robot(recording, robot_id, config, url, speed, mission_id)
    except ClientError as error:
        raise CommandError(str(error)) from error
    return {
        "dataset": recording.name,
        "robots": len(robots),
        "mission_id": mission_id,
        "posted": posted,
        "wall_s": time.monotonic() - began,
    }


def _post_robot(
    recording: Recording, robot_id: str, config: dict[str, Any], url: str, speed: float, mission_id: str
) -> int:
    client = RobotClient(url, mission_id, robot_id, patience_s=15.0)
    try:
        # memories in the recording bear the seal under which they were written
        tag_key = config.get("tag_memory", {}).get("key", "")
        client.create_mission(f"{recording.name} recording", tag_key)
        start_pose = _start_pose(recording, robot_id)
        next_seq = int(client.register(agent="server", config=config, start_pose=start_pose)["next_seq"])
        if next_seq:
            say(f"{robot_id} goes on at observation {next_seq}.")
        waiting = (o for o in recording.observations(robot_id) if o.seq >= next_seq)
        with progress() as display:
            task = display.add_task(
                f"posting {robot_id} to {mission_id}", total=recording.length(robot_id), completed=next_seq
            )
            for batch in _paced(waiting, speed):
                client.post([observation_to_wire(observation) for observation in batch])
                display.advance(task, len(batch))
    finally:
        client.close()
    return recording.length(robot_id) - next_seq


def _start_pose(recording: Recording, robot_id: str) -> dict[str, float] | None:
    start = recording.start_pose(robot_id)
    if start is None:
        return None
    return {**pose_to_wire(start.pose), "sd_m": start.sd_m, "sd_rad": start.sd_rad}


def _paced(observations: Iterator[Observation], speed: float) -> Iterator[list[Observation]]:
    """Yield batches when they are due: ``speed`` times as fast as their stamps, 0 for at once."""
    batch: list[Observation] = []
    began: float | None = None
    first_s = 0.0
    for observation in observations:
        if began is None:
            began, first_s = time.monotonic(), observation.stamp_s
        due = began + (observation.stamp_s - first_s) / speed if speed > 0.0 else began
        ahead_s = due - time.monotonic()
        if batch and (ahead_s > _TOGETHER_S or len(batch) == _BATCH):
            yield batch
            batch = []
            ahead_s = due - time.monotonic()
        if ahead_s > _TOGETHER_S:
            time.sleep(ahead_s)
        batch.append(observation)
    if batch:
        yield batch
