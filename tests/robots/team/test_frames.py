"""Robots are joined whatever their compasses say: by points, by meetings, by what their lasers see."""

import zlib
from dataclasses import replace

import numpy as np
import pytest

from robots.se2 import Pose2, wrap, wrap_array
from robots.team import StartPose, TeamMap, TeamRobot, TeamUpdate
from robots.types import AgentUpdate, SubmapReport

FIRST = [
    Pose2(1.0, 1.0, 0.3),
    Pose2(2.0, 1.0, 0.0),
    Pose2(4.0, 1.0, 1.0),
    Pose2(5.0, 2.0, 1.5),
    Pose2(4.5, 2.2),
]
SECOND = [
    Pose2(5.5, 1.5, 3.0),
    Pose2(4.0, 1.0, -2.0),
    Pose2(3.0, 3.0, 2.0),
    Pose2(2.0, 1.0, -1.5),
    Pose2(1.5, 2),
]
THIRD = [Pose2(7.0, 4.0, 1.0), Pose2(8.0, 2.0, -1.0), Pose2(6.0, 2.0, -2.0), Pose2(6.0, 3.5, 2.5)]
OFFS = [0.7, -0.7, 2.5]


def team_of(members: dict[str, list[AgentUpdate]], starts: dict[str, StartPose] | None = None) -> TeamUpdate:
    team = TeamMap()
    for name, updates in members.items():
        team.add_robot(name, (starts or {}).get(name))
        for update in updates:
            team.put(name, update)
    return team.solve()


def robot(update: TeamUpdate, name: str) -> TeamRobot:
    return next(robot for robot in update.robots if robot.robot_id == name)


def anchors_at(found: TeamRobot, poses: list[Pose2], world_from_truth: Pose2, atol: float = 1e-3) -> None:
    assert found.located
    expected = np.array([(world_from_truth @ pose).as_array() for pose in poses])
    np.testing.assert_allclose(found.anchors[:, :2], expected[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_array(found.anchors[:, 2] - expected[:, 2]), 0.0, atol=atol)


def world_of(poses: list[Pose2], north: float) -> Pose2:
    """The world is the first robot's map: at its start, x axis where its compass has north."""
    return Pose2(0.0, 0.0, north) @ Pose2(-poses[0].x, -poses[0].y, 0.0)


@pytest.mark.parametrize("off", OFFS)
def test_two_tags_join_robots_whose_compasses_contradict_each_other(journey, off):
    update = team_of({
        "r1": journey("r1", FIRST, {1: "A", 2: "B"}, north=0.2),
        "r2": journey("r2", SECOND, {1: "B", 3: "A"}, north=off),
    })  # fmt: skip
    world = world_of(FIRST, 0.2)
    anchors_at(robot(update, "r1"), FIRST[:3], world)
    anchors_at(robot(update, "r2"), [SECOND[0], SECOND[1], SECOND[3]], world)
    assert update.notices == ()


def test_a_compass_that_is_off_by_a_little_is_found_by_statistics(journey):
    """Eight degrees, too few to be seen at once: were it believed, tags and poses would be bent."""
    ways = [Pose2(4.0 * x, float(y), 0.1 * x) for y in (0, 3) for x in range(6)]
    tags = {k: f"T{k}" for k in range(1, 12)}
    members = {
        "r1": journey("r1", ways, tags),
        "r2": journey("r2", ways, tags),
        "r3": journey("r3", ways, tags, north=0.14),
    }
    for member, poses in zip(team_of(members).robots, [ways] * 3, strict=True):
        anchors_at(member, poses, Pose2(), atol=0.02)


def test_no_compass_at_all_but_a_chain_of_joins(journey):
    """r1 and r2 by two tags, r3 by two other tags that only r2 has read."""
    members = {
        "r1": journey("r1", FIRST, {1: "A", 2: "B"}, imu=False),
        "r2": journey(
            "r2", [*SECOND, Pose2(6, 2, 1), Pose2(8, 2, 0)], {1: "B", 3: "A", 5: "C", 6: "D"}, imu=False
        ),
        "r3": journey("r3", THIRD, {1: "D", 2: "C"}, imu=False),
    }
    world = FIRST[0].inverse()
    update = team_of(members)
    anchors_at(robot(update, "r3"), THIRD[:3], world)
    without = {name: news for name, news in members.items() if name != "r2"}
    assert not robot(team_of(without), "r3").located
    late = team_of({name: members[name] for name in ("r3", "r1", "r2")})  # in another order
    np.testing.assert_array_equal(robot(late, "r3").anchors, robot(update, "r3").anchors)


def test_a_moved_tag_among_the_shared_ones_is_outvoted(journey):
    elsewhere = [SECOND[0], Pose2(4.0, 1.0, -2.0), Pose2(9.0, 7.0, 2.0), Pose2(2.0, 1.0, -1.5), Pose2(1.5, 2)]
    tags = {1: "B", 2: "C", 3: "A", 4: "E"}
    own = [FIRST[0], FIRST[1], FIRST[2], Pose2(3.0, 3.0, 1.0), Pose2(1.5, 2)]
    update = team_of({
        "r1": journey("r1", own, {1: "A", 2: "B", 3: "C", 4: "E"}, imu=False),
        "r2": journey("r2", elsewhere, tags, imu=False),
    })  # fmt: skip
    anchors_at(robot(update, "r2"), elsewhere, own[0].inverse(), atol=0.35)  # on the way to C it is vague
    (notice,) = update.notices
    assert (notice.kind, notice.about, notice.robots) == ("moved", "C", ("r1", "r2"))


def seeing(
    updates: list[AgentUpdate], anchor: int, who: str, stamp_s: float, place: Pose2
) -> list[AgentUpdate]:
    """The updates with a meeting in the last graph: ``who`` seen at a place in the frame of a pose vertex."""
    at = max(k for k, update in enumerate(updates) if update.graph is not None)
    graph = updates[at].graph
    assert graph is not None
    offset = np.array([[place.x, place.y]])
    new = replace(
        graph,
        meeting_robots=(*graph.meeting_robots, who),
        meeting_poses=np.append(graph.meeting_poses, anchor),
        meeting_stamps_s=np.append(graph.meeting_stamps_s, stamp_s),
        meeting_offsets=np.concatenate([graph.meeting_offsets, offset]),
        meeting_covariances=np.concatenate([graph.meeting_covariances, [np.eye(2) * 0.05**2]]),
    )
    return [*updates[:at], replace(updates[at], graph=new), *updates[at + 1 :]]


def met(
    first: list[AgentUpdate], second: list[Pose2], times: list[tuple[int, Pose2, int]]
) -> list[AgentUpdate]:
    """r2 was seen by r1 from its pose vertex (index and true pose), at r2's k-th step."""
    for anchor, pose, k in times:
        first = seeing(first, anchor, "r2", 0.2 * k, pose.between(second[k]))
    return first


def test_meetings_join_robots_that_share_no_tag(journey):
    """Two apart without a compass; one is enough where both know north."""
    second = journey("r2", THIRD, {1: "C", 2: "D"}, imu=False)
    twice = [(1, FIRST[1], 1), (2, FIRST[2], 3)]
    first = journey("r1", FIRST, {1: "A", 2: "B"}, imu=False)
    world = FIRST[0].inverse()
    update = team_of({"r1": met(first, THIRD, twice), "r2": second})
    assert not robot(team_of({"r1": first, "r2": second}), "r2").located
    # two seconds apart at least: meetings nearer in time share their errors
    assert not robot(update, "r2").located
    slow = [replace(u, stamp_s=u.stamp_s * 20.0) for u in second]
    first = seeing(first, 1, "r2", 4.0, FIRST[1].between(THIRD[1]))
    first = seeing(first, 2, "r2", 12.0, FIRST[2].between(THIRD[3]))
    update = team_of({"r1": first, "r2": slow})
    anchors_at(robot(update, "r2"), THIRD[:3], world, atol=0.02)
    assert robot(update, "r2").covariance is not None
    once = seeing(journey("r1", FIRST, {1: "A", 2: "B"}), 1, "r2", 4.0, FIRST[1].between(THIRD[1]))
    north = [replace(u, stamp_s=u.stamp_s * 20.0) for u in journey("r2", THIRD, {1: "C", 2: "D"})]
    anchors_at(robot(team_of({"r1": once, "r2": north}), "r2"), THIRD[:3], world_of(FIRST, 0.0), atol=0.02)


def test_a_false_meeting_bends_nothing(journey):
    members = {
        "r1": journey("r1", FIRST, {1: "A", 2: "B"}),
        "r2": journey("r2", SECOND, {1: "B", 3: "A"}),
    }
    members["r1"] = seeing(members["r1"], 1, "r2", 0.6, Pose2(7.0, -5.0, 0.0))
    members["r1"] = seeing(members["r1"], 1, "nobody", 0.6, Pose2(1.0, 0.0, 0.0))
    members["r1"] = seeing(members["r1"], 1, "r1", 0.6, Pose2(np.nan, 0.0, 0.0))
    members["r1"] = seeing(members["r1"], 9, "r2", 0.6, Pose2(1.0, 0.0, 0.0))
    anchors_at(
        robot(team_of(members), "r2"), [SECOND[0], SECOND[1], SECOND[3]], world_of(FIRST, 0.0), atol=0.02
    )


def view(anchor: int, version: int, world_from_anchor: Pose2, turn: float) -> SubmapReport:
    """An L-shaped room with a pillar as a submap whose grid is turned by ``turn`` in the world."""
    r, size = 0.05, 200
    world_from_grid = Pose2(world_from_anchor.x, world_from_anchor.y, turn) @ Pose2(-5.0, -5.0, 0.0)
    rows, columns = np.mgrid[0:size, 0:size]
    centres = np.column_stack([columns.ravel() + 0.5, rows.ravel() + 0.5]) * r
    x, y = world_from_grid.transform(centres).T

    def inside(grown: float) -> np.ndarray:
        room = (x > -grown) & (x < 6 + grown) & (y > -grown) & (y < 4 + grown)
        corner = (x > 4.5 + grown) & (y > 2.8 + grown)
        pillar = (abs(x - 1.2) < 0.3 - grown) & (abs(y - 2.9) < 0.2 - grown)
        return room & ~corner & ~pillar

    cells = np.where(inside(0.0), -20, np.where(inside(0.05), 40, 0)).astype(np.int8).reshape(size, size)
    anchor_from_grid = world_from_anchor.inverse() @ world_from_grid
    return SubmapReport(anchor, version, anchor_from_grid, r, size, size, zlib.compress(cells.tobytes()))


def looking(
    updates: list[AgentUpdate], poses: list[Pose2], anchors: list[int], north: float
) -> list[AgentUpdate]:
    """The updates with what was seen of the room from the start, and a submap that is still being written."""
    last = anchors[-1]
    submaps = (view(0, 5, poses[0], -north), view(last, 2, poses[last], -north))
    return [*updates[:-1], replace(updates[-1], submaps=submaps)]


@pytest.mark.parametrize("imu", [False, True], ids=["without compass", "compass off"])
def test_one_shared_tag_and_the_room_round_it_join_two_robots(journey, imu):
    off = 0.7 if imu else 0.0
    first = journey("r1", FIRST, {2: "B", 4: "X"}, imu=imu)
    second = journey("r2", SECOND, {1: "B", 4: "Y"}, imu=imu, north=off)
    world = world_of(FIRST, 0.0) if imu else FIRST[0].inverse()
    if not imu:
        assert not robot(team_of({"r1": first, "r2": second}), "r2").located
    seen = {"r1": looking(first, FIRST, [0, 2], 0.0), "r2": looking(second, SECOND, [0, 1], off)}
    anchors_at(robot(team_of(seen), "r2"), [SECOND[0], SECOND[1], SECOND[4]], world, atol=0.05)


def test_by_laser_robots_agree_on_a_wall_their_compasses_turn(journey):
    """Compasses two degrees apart: the room, ten metres of way from the only shared tag, is drawn once."""
    off = 0.035
    plain = {
        "r1": journey("r1", FIRST, {2: "B", 4: "X"}),
        "r2": journey("r2", SECOND, {1: "B", 4: "Y"}, north=off),
    }
    seen = {
        "r1": looking(plain["r1"], FIRST, [0, 2], 0.0),
        "r2": looking(plain["r2"], SECOND, [0, 1], off),
    }
    turned = [wrap(robot(team_of(each), "r2").anchors[0, 2] - SECOND[0].theta) for each in (plain, seen)]
    assert abs(turned[0]) > 0.012
    assert abs(turned[1]) < 0.5 * abs(turned[0])
