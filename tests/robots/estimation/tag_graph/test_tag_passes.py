"""What the agent makes of tags: restarts, edges, loops that close. Without a laser: all of it is known."""

from dataclasses import replace
from itertools import pairwise
from math import pi

import numpy as np
import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig
from robots.se2 import Pose2
from robots.types import Displacement, DistanceTurn, ImuReading, Observation, TagSighting
from tests.robots.recorded import driving


def test_at_a_tag_the_filter_restarts_and_the_way_becomes_an_edge():
    agent = RobotAgent("r1", AgentConfig())
    log = driving(61, DistanceTurn(0.1, 0.0), {20: "A", 40: "B", 60: "A"})
    updates = [agent.step(observation) for observation in log]
    at_a = updates[20]
    assert at_a.graph is not None
    assert at_a.graph.tag_ids == ("A",)
    assert at_a.anchor == 1
    assert at_a.anchor_from_base == Pose2()
    np.testing.assert_allclose(at_a.graph.poses, [[0, 0, 0], [2.0, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(at_a.graph.edge_poses, [[2.0, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(at_a.graph.tags, [[2.0, 0.0]], atol=1e-9)
    assert at_a.graph.stamps_s.tolist() == [0.0, 4.0]
    assert [u.graph is not None for u in updates[21:40]] == [False] * 19
    since = updates[30].anchor_from_base
    assert (since.x, since.y, since.theta) == pytest.approx((1.0, 0.0, 0.0))
    at_b, back = updates[40], updates[60]
    assert at_b.graph is not None
    assert back.graph is not None
    assert at_b.graph.tag_ids == back.graph.tag_ids == ("A", "B")
    assert back.anchor == 3
    assert back.graph.sighting_pairs.tolist() == [[1, 0], [2, 1], [3, 0]]
    assert back.graph.edge_pairs.tolist() == [[0, 1], [1, 2], [2, 3]]
    assert np.linalg.eigvalsh(back.graph.edge_covariances)[:, 0].min() > 0.0


def test_a_tag_read_twice_in_one_pass_is_one_sighting():
    log = driving(40, DistanceTurn(0.1, 0.0), {20: "A", 21: "A", 23: "A", 26: "A", 27: "B", 28: "A"})
    agent = RobotAgent("r1", AgentConfig())
    updates = [agent.step(observation) for observation in log]
    graph = agent.report().graph
    assert graph is not None
    #            first pass  0.6 m on     another    back at A
    assert graph.sighting_pairs.tolist() == [[1, 0], [2, 0], [3, 1], [4, 0]]
    assert [u.seq for u in updates if u.graph is not None] == [0, 20, 26, 27, 28]


def test_two_tags_under_the_antenna_at_once_share_a_pose():
    agent = RobotAgent("r1", AgentConfig())
    agent.step(Observation(0, 0.0))
    agent.step(
        Observation(1, 0.2, DistanceTurn(1.0, 0.0), tag_sightings=(TagSighting("A"), TagSighting("B")))
    )
    graph = agent.report().graph
    assert graph is not None
    assert graph.tag_ids == ("A", "B")
    assert len(graph.poses) == 2
    assert graph.sighting_pairs.tolist() == [[1, 0], [1, 1]]


CORNERS = {0: "A", 100: "B", 200: "C", 300: "D", 400: "A"}


def crooked_square(imu: bool) -> tuple[list[Observation], list[Pose2]]:
    """10 m sides driven truly, tags at the corners.

    The wheels roll 8 % long on the first two sides and, without a compass, turn 0.01 rad/m too much.
    """
    true, log, poses = Pose2(), [], []
    for seq in range(401):
        turn = pi / 2 if seq and seq % 100 == 0 else 0.0
        if seq:
            true = true @ Pose2(0.1, 0.0, turn)
        log.append(
            Observation(
                seq,
                seq * 0.2,
                Displacement(0.108 if seq <= 200 else 0.1, 0.0, turn + 0.001) if seq else None,
                ImuReading(true.theta) if imu else None,
                tag_sightings=(TagSighting(CORNERS[seq]),) if seq in CORNERS else (),
            )
        )
        poses.append(true)
    return log, poses


@pytest.mark.parametrize("imu", [False, True], ids=["wheels", "imu"])
def test_coming_back_to_a_known_tag_pulls_the_whole_loop_straight(imu):
    log, true = crooked_square(imu)
    agent = RobotAgent("r1", AgentConfig())
    updates = [agent.step(observation) for observation in log]
    before, after = updates[-2], updates[-1]
    assert before.pose.distance(true[-2]) > 1.0
    assert after.graph is not None
    at = np.searchsorted(after.graph.stamps_s, [corner * 0.2 - 1e-6 for corner in CORNERS])
    solved = after.graph.poses[at]
    errors = [
        Pose2.from_array(pose).distance(true[corner]) for pose, corner in zip(solved, CORNERS, strict=True)
    ]
    reckoned = [updates[corner].pose.distance(true[corner]) for corner in (0, 100, 200, 300)]
    reckoned.append(before.pose.distance(true[-2]))
    assert errors[-1] < 0.15  # under the antenna again
    assert np.linalg.norm(errors) < 0.7 * np.linalg.norm(reckoned)
    assert np.trace(after.covariance) < 0.5 * np.trace(before.covariance)
    assert after.pose.distance(true[-1]) == pytest.approx(errors[-1])


def test_true_poses_are_not_corrected():
    """The experiments' oracle: a tag that was moved does not bend it."""
    log, true = crooked_square(False)
    exact = [
        replace(o, odometry=Displacement(*(a.between(b).as_array())) if o.seq else None)
        for o, a, b in zip(log, [true[0], *true], true, strict=False)
    ]
    moved = [replace(o, tag_sightings=(TagSighting("A"),)) if o.seq == 250 else o for o in exact]
    agent = RobotAgent("r1", AgentConfig(poses="truth"))
    for observation, pose in zip(moved, true, strict=True):
        assert agent.step(observation).pose.distance(pose) < 1e-9


def test_covariance_of_the_pose_contains_the_way_since_the_start():
    agent = RobotAgent("r1", AgentConfig())
    spread = []
    for observation in driving(100, DistanceTurn(0.1, 0.0), {30: "A", 60: "B", 90: "C"}):
        spread.append(agent.step(observation).covariance)
    for a, b in pairwise(spread):
        assert np.trace(b) > np.trace(a)  # through restarts too
        assert np.linalg.eigvalsh(b)[0] > -1e-12
