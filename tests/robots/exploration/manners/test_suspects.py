"""Going to what looked warm until it is a victim or nothing."""

from math import atan2, hypot

from robots.se2 import Pose2, wrap
from robots.tags.marks import victim_mark
from robots.tags.memory import TagMemory
from robots.tags.window import no_cells
from robots.types import Suspect

WARM = (6.0, 2.0)


def readings(rover, place, seen_s):
    """A suspect seen once, at a time."""
    return () if rover.now_s < seen_s else (Suspect("r1-V1", place, 1, seen_s),)


def test_it_goes_nearer_and_on_again_once_it_is_a_victim(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    near = 1.8

    def suspects(r):
        gap = hypot(WARM[0] - r.pose.x, WARM[1] - r.pose.y)
        return () if gap < near else (Suspect("r1-V1", WARM, 1, r.now_s),)

    first = robot.drive(1.0, suspects=suspects)
    assert first.reason.startswith("a possible victim 6.")
    assert first.goal_m == WARM
    robot.drive(40.0, lambda d: "victim" not in d.reason, suspects)
    assert hypot(WARM[0] - robot.pose.x, WARM[1] - robot.pose.y) < near + 0.1
    assert robot.seen[-1].activity == "exploring"


def test_what_is_not_seen_again_in_plain_view_was_nothing_and_is_not_gone_to_twice(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2(3.0, 0.0, 0.0))
    robot.drive(15.0, suspects=lambda r: readings(r, (5.0, 1.0), 1.0))
    looking = [k for k, d in enumerate(robot.seen) if "victim" in d.reason]
    assert 0.2 * len(looking) < 5.0
    assert looking == list(range(looking[0], looking[-1] + 1))
    assert robot.seen[-1].activity == "exploring"


def test_what_cannot_be_got_at_is_left(rover, make_hall):
    robot = rover(make_hall(walls=((8.5, -1.5, 18.0, 4.5),)), Pose2(6.0, 0.0, 0.0))
    robot.drive(3.0, suspects=lambda r: readings(r, (11.5, 0.0), 0.0))
    assert not any("victim" in d.reason for d in robot.seen[10:])


def test_what_was_seen_long_ago_or_far_away_does_not_call(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2(0.0, 0.0, 0.0))
    robot.now_s = 100.0
    robot.drive(
        1.0, suspects=lambda r: (Suspect("r1-V1", WARM, 1, 3.0), Suspect("r1-V2", (9.0, 0.0), 1, 100.0))
    )
    assert not any("victim" in d.reason for d in robot.seen)


def test_beside_the_place_it_turns_to_face_it(rover, make_hall):
    fused = make_hall(known_to_m=15.0, walls=((5.0, 1.5, 6.0, 2.5),))  # it lies on something
    robot = rover(fused, Pose2(2.0, 0.0, 0.0))
    place = (5.5, 2.0)

    def seen_now_and_then(r):
        return (Suspect("r1-V1", place, int(r.now_s), r.now_s),)

    robot.drive(25.0, lambda d: d.reason.startswith("looking whether"), seen_now_and_then)
    robot.drive(3.0, suspects=seen_now_and_then)
    bearing = wrap(atan2(place[1] - robot.pose.y, place[0] - robot.pose.x) - robot.pose.theta)
    assert abs(bearing) < 0.3
    assert "looking whether what was warm is a victim" in {d.reason for d in robot.seen}


def told_of_victim(robot, place, tag=(2.0, 0.0)):
    """Let a robot read a tag in which another robot left a victim at a place."""
    mark = victim_mark("r2-V1", 0.9, 60.0, place[0] - tag[0], place[1] - tag[1])
    robot.tags["T1"] = tag
    robot.explorer.claims.hear("T1", TagMemory(no_cells(), victims=(mark,)), robot.now_s)


def test_what_a_tag_tells_to_be_a_victim_is_passed_by_and_the_reason_says_so(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    told_of_victim(robot, WARM)
    robot.drive(18.0, suspects=lambda r: readings(r, (WARM[0] + 0.6, WARM[1]), 1.0))
    assert not any("possible victim" in d.reason for d in robot.seen)
    said = [d.reason for d in robot.seen if d.reason.endswith("a tag says that a robot found a victim there")]
    assert "passing the warm spot 6 m away" in said[0]
    assert not robot.seen[-1].reason.endswith("victim there")  # said for a while
    assert robot.pose.x > 4.0


def test_another_warm_place_beside_a_known_victim_is_gone_to(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    told_of_victim(robot, (WARM[0], WARM[1] - 2.5))
    robot.drive(2.0, suspects=lambda r: readings(r, WARM, 0.0))
    assert robot.seen[-1].reason.startswith("a possible victim")


def test_it_turns_away_once_it_reads_that_the_victim_is_known(rover, make_hall):
    robot = rover(make_hall(known_to_m=15.0), Pose2())
    robot.drive(2.0, suspects=lambda r: readings(r, WARM, 0.0))
    assert robot.seen[-1].goal_m == WARM
    told_of_victim(robot, WARM)
    after = robot.drive(1.0, suspects=lambda r: readings(r, WARM, 0.0))
    assert after.goal_m != WARM
    assert after.activity == "exploring"
