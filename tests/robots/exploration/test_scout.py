"""The scout by itself: stepped by somebody who knows the pose and the map."""

from dataclasses import replace

import numpy as np

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig, TagMemoryConfig
from robots.exploration.scout import Scout, Situation
from robots.mapping.map_keeper import MapKeeper
from robots.orders import RobotOrder
from robots.se2 import Pose2
from robots.tags.marks import Note, Notes, Pass, VictimMark
from robots.tags.memory import CLOSED, TagMemory
from robots.tags.sealed import close_memory, open_memory
from robots.types import LaserScan, TagSighting

CONFIG = AgentConfig(
    tag_memory=TagMemoryConfig(key="a1"), deployment=DeploymentConfig(rate_per_m=1e6), poses="truth"
)
KEY = CONFIG.tag_memory.key_bytes
HERE = {"T": (0.5, 0.0)}


def situation(scan=True, **more):
    """Stand in the middle of a corridor along x, 2 m wide and open at both ends."""
    angles = np.linspace(-np.pi, np.pi, 361)
    ranges = np.minimum(1.0 / np.maximum(np.abs(np.sin(angles)), 1e-3), 4.0).astype(np.float32)
    view = LaserScan(ranges, -np.pi, float(angles[1] - angles[0]), 4.0)
    maps = MapKeeper(CONFIG.mapping)
    maps.begin(0, Pose2(), Pose2(), 0.0)
    maps.add_free(Pose2(), CONFIG.body.radius_m)
    for _ in range(3):
        maps.add_scan(Pose2(), view)
    maps.draw([Pose2()])
    given = {"stamp_s": 1.0, "pose": Pose2(), "fused": maps.fused, "distance_m": 1.0, "tag_place": HERE.get}
    return Situation(scan=view if scan else None, **(given | more))


def test_it_drives_to_the_edge_of_the_unknown_and_drops_tags():
    intent = Scout("r1", CONFIG).step(situation())
    assert intent.decision.activity == "exploring"
    assert abs(intent.decision.path_m[-1, 0]) > 2.5
    assert intent.drop
    assert not Scout("r1", CONFIG).step(situation(held=True)).drop
    assert not Scout("r1", CONFIG).step(situation(tags_left=0)).drop


def test_without_a_scan_it_stays_with_its_decision_but_answers_tags():
    scout = Scout("r1", CONFIG)
    decided = scout.step(situation()).decision
    intent = scout.step(situation(scan=False, read=(TagSighting("T"),)))
    assert intent.decision is decided
    assert not intent.drop
    (write,) = intent.writes
    assert (open_memory(write.memory, "T", KEY).memory.cells == CLOSED).any()


def test_strangers_are_not_believed_nor_overwritten_and_without_north_nothing_is_told_of_the_ground():
    cells = np.full((3, 3), CLOSED, np.uint8)

    def sighting(key):
        return TagSighting("T", close_memory(TagMemory(cells), 1, "T", key, 196))

    for key, north, told in ((KEY, True, True), (KEY, False, False), (b"stranger", True, False)):
        scout = Scout("r1", CONFIG)
        intent = scout.step(situation(read=(sighting(key),), north=north))
        grid = scout.explorer._grid
        claims = scout.explorer.claims
        assert bool((claims.survey(grid, claims.tags(HERE.get)).claimed == CLOSED).any()) == told
        assert bool(intent.writes) == told


def test_with_a_small_map_it_goes_to_the_edge_of_that_and_forgets_the_rest():
    planning = PlanningConfig(local_map_m=4.0)
    scout = Scout("r1", replace(CONFIG, planning=planning))
    for second in range(3):
        intent = scout.step(situation(stamp_s=float(second)))
    assert 1.5 < abs(intent.decision.path_m[-1, 0]) < 2.1
    assert scout.explored_m2 < 16.0


def test_where_others_were_heard_is_where_it_goes_when_the_battery_does_not_reach_home():
    scout = Scout("r1", CONFIG)
    scout.step(situation(pose=Pose2(1.0, 0.2, 0.0)))
    assert scout.explorer.homing.contact_m is None
    scout.step(situation(pose=Pose2(1.0, 0.2, 0.0), heard=(b"even a garbled message",)))
    assert scout.explorer.homing.contact_m == (1.0, 0.2)


def test_a_robot_with_rules_of_its_own_for_the_ground_keeps_all_else_that_a_tag_holds():
    said = TagMemory(
        np.full((5, 5), CLOSED, np.uint8),
        victims=(VictimMark(200, 3, 40, -20, 77),),
        notes=Notes((Note(1, "Kim", "gas"),)),
        passes=(Pass(2, 0, 4, 0, 99),),
    )
    scout = Scout("r1", replace(CONFIG, planning=PlanningConfig(explore="kleiner-printed")))
    scout.step(situation())
    intent = scout.step(
        situation(stamp_s=2.0, read=(TagSighting("T", close_memory(said, 1, "T", KEY, 196)),))
    )
    (write,) = intent.writes
    left = open_memory(write.memory, "T", KEY).memory
    assert len(left.frontiers_m) > 0
    assert (left.cells == CLOSED).sum() == 25
    assert (left.victims, left.notes) == (said.victims, said.notes)
    assert {passed.key for passed in left.passes} > {99}


def test_an_order_to_drop_a_tag_is_done_once_it_has_fallen_and_fails_where_it_does_not():
    order = RobotOrder("o1", "drop_tag")
    for left, came in ((4, ("done", "dropped a tag")), (5, ("failed", "no tag fell"))):
        scout = Scout("r1", replace(CONFIG, deployment=DeploymentConfig(rate_per_m=0.0)))
        scout.step(situation(tags_left=5, orders=(order,)))
        assert (
            scout.step(situation(stamp_s=1.2, tags_left=5)).drop or scout.explorer.errands.tag_wanted is False
        )
        assert scout.explorer.errands.take_reports() == ()
        doubts = ()
        for second in range(2, 7):
            intent = scout.step(situation(stamp_s=float(second), tags_left=left))
            assert not intent.drop
            doubts += intent.doubts
        (report,) = scout.explorer.errands.take_reports()
        assert (report.order_id, report.state) == ("o1", came[0])
        assert report.text.startswith(came[1])
        assert len(doubts) == (left == 5)
