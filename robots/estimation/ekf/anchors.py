"""Poses left behind, hung on the tags seen from them: when the filter moves the tags, they follow."""

from __future__ import annotations

from math import atan2, cos, hypot, sin

import numpy as np

from robots.estimation.ekf.state import TagState
from robots.se2 import Pose2

_APART_M = 0.5  # two tags nearer than this do not tell a turn


class HungAnchors:
    """Remembers poses with where one or two tags were believed then."""

    def __init__(self, start: Pose2) -> None:
        self._poses = [start]
        self._tags: list[tuple[tuple[str, float, float], ...]] = [()]

    def add(self, pose: Pose2, seen: list[str], state: TagState) -> None:
        """Remember a pose, hung on the tags ``seen`` last, the newest first."""
        held = [(tag_id, *state.place(tag_id)[0].tolist()) for tag_id in seen if tag_id in state]
        self._poses.append(pose)
        self._tags.append(tuple(held[:2]))

    def poses(self, state: TagState) -> list[Pose2]:
        """Return the poses as the tags are believed now."""
        names = {tag_id for held in self._tags for tag_id, _, _ in held if tag_id in state}
        now = {tag_id: tuple(state.place(tag_id)[0].tolist()) for tag_id in names}
        return [_moved(pose, held, now) for pose, held in zip(self._poses, self._tags, strict=True)]


def _moved(
    pose: Pose2, held: tuple[tuple[str, float, float], ...], now: dict[str, tuple[float, float]]
) -> Pose2:
    known = [each for each in held if each[0] in now]
    if not known:
        return pose
    (tag_id, x, y), turn = known[0], 0.0
    here = now[tag_id]
    if len(known) > 1:
        other, (there_x, there_y) = known[1], now[known[1][0]]
        if hypot(other[1] - x, other[2] - y) > _APART_M:
            turn = atan2(there_y - here[1], there_x - here[0]) - atan2(other[2] - y, other[1] - x)
    c, s = cos(turn), sin(turn)
    dx, dy = pose.x - x, pose.y - y
    moved = np.array([here[0] + c * dx - s * dy, here[1] + s * dx + c * dy, pose.theta + turn])
    return Pose2.from_array(moved)
