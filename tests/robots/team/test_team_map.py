"""The team's map: where robots stand to one another, told by the tags they share and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from robots.codec import encode
from robots.se2 import Pose2, wrap_array
from robots.team import StartPose, TeamMap, TeamRobot, TeamUpdate
from robots.types import AgentUpdate

FIRST = [Pose2(0.0, 0.0, 0.3), Pose2(2.0, 0.0, 0.0), Pose2(4.0, 1.0, 1.0), Pose2(4.0, 4.0, 1.5)]
FIRST_TAGS = {1: "A", 2: "B", 3: "C"}
SECOND = [Pose2(6.0, 5.0, 3.0), Pose2(4.0, 4.0, -2.0), Pose2(4.0, 1.0, -1.5), Pose2(7.0, 0.0, 0.0)]
SECOND_TAGS = {1: "C", 2: "B", 3: "D"}
THIRD = [Pose2(9.0, -3.0, 1.0), Pose2(7.0, 0.0, 2.0), Pose2(8.0, 2.0, 1.0)]


def team_of(members: dict[str, list[AgentUpdate]], starts: dict[str, StartPose] | None = None) -> TeamUpdate:
    team = TeamMap()
    for name, updates in members.items():
        team.add_robot(name, (starts or {}).get(name))
        for update in updates:
            team.put(name, update)
    return team.solve()


def robot(update: TeamUpdate, name: str) -> TeamRobot:
    return next(robot for robot in update.robots if robot.robot_id == name)


def anchors_at(
    found: TeamRobot, poses: list[Pose2], world_from_truth: Pose2 | None = None, atol: float = 1e-5
):
    expected = np.array([((world_from_truth or Pose2()) @ pose).as_array() for pose in poses])
    np.testing.assert_allclose(found.anchors[:, :2], expected[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_array(found.anchors[:, 2] - expected[:, 2]), 0.0, atol=atol)


def known(start: Pose2, sd_m: float = 0.05, sd_rad: float = 0.02) -> StartPose:
    return StartPose(start, sd_m, sd_rad)


def test_two_robots_that_read_the_same_tags_stand_in_one_frame(journey):
    update = team_of(
        {"r1": journey("r1", FIRST, FIRST_TAGS), "r2": journey("r2", SECOND, SECOND_TAGS)},
    )
    assert all(member.located for member in update.robots)
    anchors_at(robot(update, "r1"), FIRST)  # r1's map is the world: north up, where it started
    anchors_at(robot(update, "r2"), SECOND)
    places = {tag.tag_id: (tag.x_m, tag.y_m) for tag in update.tags}
    assert places["A"] == pytest.approx((2.0, 0.0), abs=1e-5)
    assert places["D"] == pytest.approx((7.0, 0.0), abs=1e-5)
    by_tag = {tag.tag_id: tag for tag in update.tags}
    assert by_tag["B"].robots == ("r1", "r2")
    assert by_tag["B"].sightings == 2
    assert by_tag["A"].robots == ("r1",)
    assert update.links == (("A", "B"), ("B", "C"), ("B", "D"))
    for tag in update.tags:
        assert np.linalg.eigvalsh(tag.covariance)[0] > 0.0


def test_with_compasses_one_shared_tag_is_enough(journey):
    update = team_of({"r1": journey("r1", FIRST, {3: "C"}), "r2": journey("r2", SECOND, {1: "C"})})
    assert robot(update, "r2").located
    anchors_at(robot(update, "r2"), SECOND[:2])


def test_without_compasses_it_takes_two_tags_apart(journey):
    alone = {"r1": journey("r1", FIRST, FIRST_TAGS, imu=False)}
    world = FIRST[0].inverse()  # without a compass the first robot's map begins with its own heading
    two = team_of({**alone, "r2": journey("r2", SECOND, SECOND_TAGS, imu=False)})
    assert robot(two, "r2").located
    anchors_at(robot(two, "r1"), FIRST, world)
    anchors_at(robot(two, "r2"), SECOND, world)
    one = team_of({**alone, "r2": journey("r2", SECOND, {1: "C"}, imu=False)})
    assert not robot(one, "r2").located


def test_tags_at_one_place_say_nothing_about_the_rotation(journey):
    beside = [*FIRST, Pose2(4.0, 4.5, 1.5)]
    near = [Pose2(6.0, 5.0, 3.0), Pose2(4.0, 4.5, -2.0), Pose2(4.0, 4.0, -2.0)]
    update = team_of({
        "r1": journey("r1", beside, {3: "C", 4: "E"}, imu=False),
        "r2": journey("r2", near, {1: "E", 2: "C"}, imu=False),
    })  # fmt: skip
    assert not robot(update, "r2").located


def test_a_robot_joins_by_way_of_another(journey):
    update = team_of({
        "r1": journey("r1", FIRST, FIRST_TAGS),
        "r2": journey("r2", SECOND, SECOND_TAGS),
        "r3": journey("r3", THIRD, {1: "D", 2: "E"}),
    })  # fmt: skip
    assert robot(update, "r3").located
    anchors_at(robot(update, "r3"), THIRD)


def test_a_robot_that_nothing_joins_stays_out_of_the_map(journey):
    lonely = journey("r2", SECOND, {1: "X", 2: "Y"}, heat={3: (0.0, 1.0)})
    together = team_of({"r1": journey("r1", FIRST, FIRST_TAGS), "r2": lonely})
    without = team_of({"r1": journey("r1", FIRST, FIRST_TAGS)})
    assert not robot(together, "r2").located
    anchors_at(robot(together, "r2"), SECOND[:3], Pose2(-SECOND[0].x, -SECOND[0].y, 0.0))  # its own map
    assert {tag.tag_id for tag in together.tags} == {"A", "B", "C"}
    assert together.victims == ()
    assert together.links == without.links
    assert encode(replace(together, robots=())) == encode(replace(without, robots=()))


def test_surveyed_starts_are_the_world(journey):
    """Without a shared tag, each stands where it was surveyed; the world is the survey's."""
    shift = Pose2(100.0, 50.0, 0.0)
    starts = {"r1": known(shift @ FIRST[0]), "r2": known(shift @ SECOND[0])}
    members = {"r1": journey("r1", FIRST, {1: "A"}), "r2": journey("r2", SECOND, {3: "D"})}
    update = team_of(members, starts)
    anchors_at(robot(update, "r1"), FIRST[:2], shift)
    anchors_at(robot(update, "r2"), [SECOND[0], SECOND[3]], shift)
    only_second = team_of(members, {"r2": starts["r2"]})
    assert not robot(only_second, "r1").located
    assert robot(only_second, "r2").located


def test_a_survey_counts_as_much_as_it_claims(journey):
    """Two surveys that contradict the tags by 30 cm: the sure one stands, the vague one gives way."""
    wrong = Pose2(SECOND[0].x + 0.3, SECOND[0].y, SECOND[0].theta)
    members = {"r1": journey("r1", FIRST, FIRST_TAGS), "r2": journey("r2", SECOND, SECOND_TAGS)}
    vague = team_of(members, {"r1": known(FIRST[0], 0.01), "r2": known(wrong, 2.0)})
    anchors_at(robot(vague, "r1"), FIRST, atol=0.01)
    anchors_at(robot(vague, "r2"), SECOND, atol=0.02)
    even = team_of(members, {"r1": known(FIRST[0], 1.0), "r2": known(wrong, 1.0)})
    assert 0.1 < robot(even, "r1").anchors[0, 0] - FIRST[0].x < 0.2


@pytest.mark.parametrize("off", [0.3, -1.5, 3.0])
def test_a_vague_heading_is_corrected_by_the_compass_of_another(journey, off):
    """Where r2 stands was surveyed, not where it looked; r1 was surveyed well, and both know north."""
    wrong = Pose2(SECOND[0].x, SECOND[0].y, SECOND[0].theta + off)
    members = {"r1": journey("r1", FIRST, FIRST_TAGS), "r2": journey("r2", SECOND, SECOND_TAGS)}
    update = team_of(members, {"r1": known(FIRST[0], 0.01, 0.001), "r2": known(wrong, 1.0, 3.0)})
    anchors_at(robot(update, "r1"), FIRST, atol=0.01)
    anchors_at(robot(update, "r2"), SECOND, atol=0.01)
    alone = team_of({**members, "r2": journey("r2", SECOND, {3: "X"})},
                    {"r1": known(FIRST[0], 0.01, 0.001), "r2": known(wrong, 0.01, 3.0)})  # fmt: skip
    anchors_at(robot(alone, "r2"), [SECOND[0], SECOND[3]], atol=0.01)  # north is enough


def test_a_surveyed_heading_stands_where_no_compass_contradicts(journey):
    """The mission's world need not look north: the survey of the only robot says how it lies."""
    turned = Pose2(10.0, 20.0, 1.2)
    update = team_of(
        {"r1": journey("r1", FIRST, FIRST_TAGS), "r2": journey("r2", SECOND, SECOND_TAGS)},
        {"r1": known(turned @ FIRST[0])},
    )
    anchors_at(robot(update, "r1"), FIRST, turned)
    anchors_at(robot(update, "r2"), SECOND, turned)


def test_a_robot_without_a_survey_does_not_hold_those_that_have_one(journey):
    """The first in the alphabet has none: it follows the sure survey, not the mean of both."""
    through = [*THIRD[:2], Pose2(4.0, 1.0, 2.0), Pose2(4.0, 4.0, 2.0)]
    wrong = Pose2(THIRD[0].x + 0.3, THIRD[0].y, THIRD[0].theta)
    members = {
        "r1": journey("r1", FIRST, FIRST_TAGS),
        "r2": journey("r2", SECOND, SECOND_TAGS),
        "r3": journey("r3", through, {1: "D", 2: "B", 3: "C"}),
    }
    update = team_of(members, {"r2": known(SECOND[0], 0.01), "r3": known(wrong, 3.0)})
    anchors_at(robot(update, "r2"), SECOND, atol=0.01)
    anchors_at(robot(update, "r1"), FIRST, atol=0.03)


def test_the_team_corrects_what_one_robot_cannot(journey):
    """r2 never closes a loop, but r1 has been where it ends."""
    loop = [Pose2(4.0 * k, 0.0, 0.0) for k in range(4)]
    stretched = journey("r2", loop, {0: "S", 1: "T", 3: "U"}, stretch=1.08)
    alone = robot(team_of({"r2": stretched}), "r2").anchors
    assert alone[-1, 0] == pytest.approx(12.0 * 1.08, abs=0.01)
    right = journey("r1", loop, {0: "S", 3: "U"})
    both = robot(team_of({"r1": right, "r2": stretched}, {"r1": known(loop[0], 0.001, 0.001)}), "r2").anchors
    assert abs(both[-1, 0] - 12.0) < 0.6 * 0.96


def test_victims_of_one_place_are_one(journey):
    """r1 sees one at (4, 2), r2 the same and another at (7, 1); a third robot has no opinion."""
    r1 = journey("r1", FIRST, FIRST_TAGS, heat={2: (np.pi / 2 - 1.0, 1.0)})
    r2 = journey("r2", SECOND, SECOND_TAGS, heat={2: (np.pi / 2 + 1.5, 1.0), 3: (np.pi / 2, 1.0)})
    update = team_of({"r1": r1, "r2": r2})
    assert len(update.victims) == 2
    by_robots = {victim.robots: victim for victim in update.victims}
    shared, single = by_robots[("r1", "r2")], by_robots[("r2",)]
    assert (shared.x_m, shared.y_m) == pytest.approx((4.0, 2.0), abs=0.02)
    assert (single.x_m, single.y_m) == pytest.approx((7.0, 1.0), abs=0.02)
    assert shared.sightings == 6
    assert single.sightings == 3
    only = team_of({"r1": r1}).victims[0]
    assert shared.confidence > only.confidence
    assert np.linalg.eigvalsh(only.covariance - shared.covariance)[0] > -1e-9
    assert shared.first_seen_s == min(only.first_seen_s, shared.first_seen_s)
    assert shared.last_seen_s >= only.last_seen_s


def test_an_unknown_robot_is_refused(journey):
    with pytest.raises(KeyError):
        TeamMap().put("r9", journey("r9", FIRST, FIRST_TAGS)[0])


def test_a_team_of_nobody_is_empty():
    update = TeamMap().solve()
    assert update == TeamUpdate((), (), (), (), None, 0.0) or encode(update) == encode(
        TeamUpdate((), (), (), (), None, 0.0)
    )
    team = TeamMap()
    team.add_robot("r1", None)
    assert team.solve().robots == ()  # nothing heard of it yet
