"""Two robots that report as one, and graphs that cannot be used: told, and survived by the others."""

from dataclasses import replace

import numpy as np
import pytest

from robots.se2 import Pose2
from robots.team import StartPose, TeamMap, TeamUpdate
from robots.types import AgentUpdate

LANE = [Pose2(2.0 * k, 0.0, 0.0) for k in range(7)]
TAGS = {k: f"T{k}" for k in range(1, 7)}
HERE = StartPose(LANE[0], 0.05, 0.02)


def team_of(members: dict[str, list[AgentUpdate]]) -> TeamUpdate:
    team = TeamMap()
    for name, updates in members.items():
        team.add_robot(name, HERE)
        for update in updates:
            team.put(name, update)
    return team.solve()


def test_a_robot_whose_way_contradicts_its_tags_is_told(journey):
    """r2 drives the lane, is carried back to its beginning, and drives it again."""
    again = [*LANE, *LANE[1:]]
    told = journey("r2", again, TAGS | {k + 6: name for k, name in TAGS.items()})
    last = told[-1].graph
    assert last is not None
    edges = last.edge_poses.copy()
    edges[6] = (2.0, 0.0, 0.0)  # what its wheels said: straight on
    told[-1] = replace(told[-1], graph=replace(last, edge_poses=edges))
    update = team_of({"r1": journey("r1", LANE, TAGS), "r2": told})
    (notice,) = update.notices
    assert (notice.kind, notice.about) == ("way", "r2")
    assert "carried" in notice.text
    assert {tag.state for tag in update.tags} == {"sound"}
    for k, name in TAGS.items():
        tag = next(tag for tag in update.tags if tag.tag_id == name)
        assert (tag.x_m, tag.y_m) == pytest.approx((2.0 * k, 0.0), abs=0.1)


def test_two_robots_under_one_name_are_survived_and_told(journey):
    """r2's updates are those of two robots in two lanes, taken in turn; one of them drives back."""
    both = []
    for k in range(7):
        both += [LANE[k], Pose2(14.0 - 2.0 * k, 30.0, 0.0)]
    tags = {2 * k: f"T{k}" for k in range(1, 7)} | {2 * k + 1: f"U{7 - k}" for k in range(1, 7)}
    told = journey("r2", both, tags)
    last = told[-1].graph
    assert last is not None
    edges = np.tile([2.0, 0.0, 0.0], (len(last.edge_poses), 1))  # each goes on by two metres in its lane
    told[-1] = replace(told[-1], graph=replace(last, edge_poses=edges))
    again = journey("r3", [Pose2(pose.x, 30.0, 0.0) for pose in LANE], {k: f"U{k}" for k in TAGS})
    team = TeamMap()
    for name, start, updates in (
        ("r1", HERE, journey("r1", LANE, TAGS)),
        ("r2", HERE, told),
        ("r3", StartPose(Pose2(0.0, 30.0, 0.0), 0.05, 0.02), again),
    ):
        team.add_robot(name, start)
        for update in updates:
            team.put(name, update)
    update = team.solve()
    assert "way" in {notice.kind for notice in update.notices}
    for robot in update.robots:
        assert robot.located
        assert np.isfinite(robot.anchors).all()


@pytest.mark.parametrize("spoilt", ["edge_poses", "sighting_offsets", "poses", "edge_covariances"])
def test_a_graph_that_is_no_graph_is_told_and_leaves_the_others_alone(journey, spoilt):
    told = journey("r2", LANE, TAGS)
    graph = told[-1].graph
    assert graph is not None
    told[-1] = replace(told[-1], graph=replace(graph, **{spoilt: getattr(graph, spoilt) * np.nan}))
    update = team_of({"r1": journey("r1", LANE, TAGS), "r2": told})
    (notice,) = update.notices
    assert (notice.kind, notice.about) == ("way", "r2")
    located = {robot.robot_id: robot.located for robot in update.robots}
    assert located == {"r1": True, "r2": False}
    assert len(update.tags) == len(TAGS)
