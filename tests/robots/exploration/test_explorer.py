"""One robot's goals: exploring until done, holding, looking round, and getting unstuck."""

import numpy as np
import pytest

from robots.config import AgentConfig, PlanningConfig
from robots.exploration.explorer import Explorer
from robots.mapping.fused import FusedGrid
from robots.se2 import Pose2
from robots.tags.memory import CLOSED, OPEN, TagMemory

CONFIG = AgentConfig(planning=PlanningConfig(explore="nearest"))
FREE, WALL = -20, 40


def room(unknown_beyond_m: float | None = None) -> FusedGrid:
    """A walled room of 6 m by 4 m, seen up to some x."""
    cells = np.full((80, 120), FREE, np.int16)
    cells[[0, -1]] = cells[:, [0, -1]] = WALL
    cells[1], cells[-2], cells[:, 1], cells[:, -2] = WALL, WALL, WALL, WALL
    if unknown_beyond_m is not None:
        cells[:, round(unknown_beyond_m / 0.05) :] = 0
    fused = FusedGrid(0.05)
    fused.put("room", 0, Pose2(), cells)
    return fused


def decide(explorer: Explorer, now_s: float, pose: Pose2, fused: FusedGrid, bumped=False, held=False):
    return explorer.decide(now_s, pose, fused, None, bumped, held)


def test_it_drives_to_the_edge_of_the_unknown():
    explorer, fused = Explorer(CONFIG), room(4.0)
    pose = Pose2(1.0, 2.0, 0.0)
    for step in range(200):
        decision = decide(explorer, 0.2 * step, pose, fused)
        assert decision.activity == "exploring"
        if decision.reason.startswith("looking round"):
            break
        pose = pose @ Pose2.exp(np.array([decision.linear_mps, 0.0, decision.angular_radps]) * 0.2)
    assert pose.x == pytest.approx(3.95 - 0.3, abs=0.15)
    assert decision.goal_m[0] == pytest.approx(3.95)
    assert decision.linear_mps == 0.0
    assert decision.angular_radps > 0.0


def test_the_path_leads_from_the_robot_to_the_goal_and_the_reason_says_so():
    decision = decide(Explorer(CONFIG), 0.0, Pose2(1.0, 2.0, 0.0), room(4.0))
    assert decision.reason.startswith("driving 3 m to the nearest edge of the unknown, 3")
    assert decision.path_m.dtype == np.float32
    np.testing.assert_allclose(decision.path_m[0], [1.0, 2.0], atol=0.06)
    np.testing.assert_allclose(decision.path_m[-1], decision.goal_m, atol=1e-6)


def test_explored_ground_is_what_is_known_free():
    explorer = Explorer(CONFIG)
    decide(explorer, 0.0, Pose2(1.0, 2.0, 0.0), room(4.0))
    assert explorer.grids.explored_m2 == pytest.approx(3.9 * 3.8, rel=0.01)


def test_a_room_without_edges_is_done_until_the_map_changes():
    explorer = Explorer(CONFIG)
    pose = Pose2(1.0, 1.0, 0.0)
    done = decide(explorer, 0.0, pose, room())
    assert (done.activity, done.linear_mps, done.angular_radps) == ("done", 0.0, 0.0)
    assert done.reason == "no edge of the unknown is left that I can reach; I am at the base"
    assert not explorer.plan_is_due(4.0)
    assert explorer.plan_is_due(6.0)
    assert decide(explorer, 6.0, pose, room(4.0)).activity == "exploring"


def test_before_the_first_map_it_waits():
    decision = decide(Explorer(CONFIG), 0.0, Pose2(), FusedGrid(0.05))
    assert (decision.activity, decision.linear_mps) == ("starting", 0.0)


def test_held_means_held_and_standing_still_by_order_is_not_being_stuck():
    explorer, fused, pose = Explorer(CONFIG), room(4.0), Pose2(1.0, 2.0, 0.0)
    decide(explorer, 0.0, pose, fused)
    for second in range(1, 30):
        decision = decide(explorer, float(second), pose, fused, held=True)
        assert (decision.activity, decision.linear_mps, decision.angular_radps) == ("holding", 0.0, 0.0)
    assert decide(explorer, 30.0, pose, fused).activity == "exploring"


def test_a_bump_is_backed_off_from_at_once_and_the_place_is_driven_round():
    explorer, fused, pose = Explorer(CONFIG), room(4.0), Pose2(1.0, 2.0, 0.0)
    before = decide(explorer, 0.0, pose, fused)
    decide(explorer, 0.2, pose, fused)
    stuck = decide(explorer, 0.4, pose, fused, bumped=True)
    assert stuck.activity == "stuck"
    assert stuck.linear_mps < 0.0
    assert decide(explorer, 1.2, pose, fused).linear_mps < 0.0
    after = decide(explorer, 2.2, pose, fused)
    assert after.activity == "exploring"
    ahead = np.array([1.0 + CONFIG.body.radius_m + 0.25, 2.0])

    def gap(path):
        return float(np.abs(path - ahead).max(axis=1).min())

    assert gap(before.path_m) < 0.1
    assert gap(after.path_m) > 0.25


def test_no_progress_for_long_enough_is_stuck():
    explorer, fused, pose = Explorer(CONFIG), room(4.0), Pose2(1.0, 2.0, 0.0)
    seen = [decide(explorer, 0.2 * k, pose, fused).activity for k in range(40)]
    first = seen.index("stuck")
    assert 0.2 * first == pytest.approx(CONFIG.planning.stuck_after_s + 0.2, abs=0.21)


def test_an_edge_that_does_not_vanish_is_put_aside_and_tried_twice_again_before_it_is_done():
    explorer, fused = Explorer(CONFIG), room(4.0)
    pose, looks, before, reasons = Pose2(3.0, 2.0, 0.0), 0, "", set()
    for step in range(1500):
        decision = decide(explorer, 0.2 * step, pose, fused)
        looks += decision.reason.startswith("looking round") and not before.startswith("looking round")
        before = decision.reason
        if decision.activity == "returning":
            reasons.add(decision.reason.partition(": ")[2].partition(";")[0])
        if decision.activity == "done":
            break
        pose = pose @ Pose2.exp(np.array([decision.linear_mps, 0.0, decision.angular_radps]) * 0.2)
    assert decision.activity == "done"
    assert decision.reason == "1 edge of the unknown is left that I could not see beyond; I am at the base"
    assert "1 edge of the unknown could not be seen beyond yet" in reasons
    assert decision.goal_m is None
    assert 3 <= looks < 20  # the edge is 3.8 m wide and looked at from several places
    much_later = decide(explorer, 0.2 * step + 700.0, pose, fused)
    assert much_later.activity == "exploring"


def test_the_goal_is_kept_while_nothing_much_cheaper_comes_up():
    """Two edges, left and right: a robot a little nearer to the other does not turn round."""
    cells = np.full((80, 160), 0, np.int16)
    cells[20:60, 40:120] = FREE
    cells[[19, 60], 38:122] = WALL
    fused = FusedGrid(0.05)
    fused.put("hall", 0, Pose2(), cells)
    explorer = Explorer(CONFIG)
    right = decide(explorer, 0.0, Pose2(4.2, 2.0, 0.0), fused).goal_m
    assert right[0] > 5.5
    assert decide(explorer, 1.5, Pose2(3.7, 2.0, 0.0), fused).goal_m[0] > 5.5
    assert decide(Explorer(CONFIG), 1.5, Pose2(3.7, 2.0, 0.0), fused).goal_m[0] < 2.5
    assert decide(explorer, 3.0, Pose2(2.9, 2.0, 0.0), fused).goal_m[0] < 2.5


def test_when_nothing_is_left_it_returns_to_its_start_and_is_done_there():
    cells = np.full((80, 120), FREE, np.int16)
    cells[:2] = cells[-2:] = cells[:, :2] = cells[:, -2:] = WALL
    fused = FusedGrid(0.05)
    fused.put("room", 0, Pose2(-1.0, -1.0), cells)
    explorer = Explorer(CONFIG)
    pose = Pose2(4.0, 2.0, 2.0)
    seen = []
    for step in range(200):
        decision = decide(explorer, 0.2 * step, pose, fused)
        seen.append(decision.activity)
        if decision.activity == "done":
            break
        np.testing.assert_allclose(decision.path_m[-1], [0.0, 0.0], atol=0.06)
        pose = pose @ Pose2.exp(np.array([decision.linear_mps, 0.0, decision.angular_radps]) * 0.2)
    assert seen == ["returning"] * (len(seen) - 1) + ["done"]
    assert pose.distance(Pose2()) == pytest.approx(1.5, abs=0.6)


def test_stuck_again_and_again_it_gives_way_for_a_while_and_then_goes_on():
    explorer, fused, pose = Explorer(CONFIG, (1, 2)), room(4.0), Pose2(1.0, 2.0, 0.0)
    now_s = 0.0
    for _ in range(2):
        for bumped in (False, False, True, *[False] * 7):
            decision = decide(explorer, now_s, pose, fused, bumped=bumped)
            now_s += 0.2
    decision = decide(explorer, now_s, pose, fused)
    assert decision.reason == "giving way: somebody may want to pass here"
    way_m = np.hypot(*np.diff(decision.path_m, axis=0).T).sum()
    assert 1.0 < way_m < 5.0
    aside = Pose2(float(decision.path_m[-1, 0]), float(decision.path_m[-1, 1]), 0.0)
    waiting = decide(explorer, now_s + 2.0, aside, fused)
    assert (waiting.linear_mps, waiting.angular_radps) == (0.0, 0.0)
    assert waiting.reason == decision.reason
    assert (
        decide(explorer, now_s + 16.0, aside, fused).goal_m is None
    )  # where it got stuck is left for a while
    assert decide(explorer, now_s + 24.0, aside, fused).goal_m is not None


def corridor() -> FusedGrid:
    """A corridor of 20 m by 2 m along x, seen from 8 m to 13 m: its left edge is nearer to the middle."""
    cells = np.full((40, 400), 0, np.int16)
    cells[2:-2, 160:260] = FREE
    cells[[0, 1, -2, -1]] = WALL
    fused = FusedGrid(0.05)
    fused.put("corridor", 0, Pose2(), cells)
    return fused


def covered(state=CLOSED) -> TagMemory:
    return TagMemory(np.full((9, 9), state, np.uint8))


def goal_after(memory: TagMemory | None, place=(4.0, 1.0)) -> float:
    """The goal's x of a robot in the middle of the corridor that has read a tag at ``place``."""
    explorer = Explorer(AgentConfig())
    if memory is not None:
        explorer.claims.hear("A", memory)
    decision = explorer.decide(0.0, Pose2(10.0, 1.0, 0.0), corridor(), None, False, False, {"A": place}.get)
    assert decision.activity == "exploring"
    return decision.goal_m[0]


def test_a_tag_that_calls_ground_covered_sends_the_next_robot_the_other_way():
    assert goal_after(None) == pytest.approx(8.0, abs=0.2)
    assert goal_after(covered()) == pytest.approx(12.95, abs=0.2)
    assert goal_after(covered(OPEN)) == pytest.approx(8.0, abs=0.2)  # somebody saw more that way


def test_tags_that_call_everything_covered_trap_nobody():
    everywhere = TagMemory(np.full((31, 31), CLOSED, np.uint8))
    assert goal_after(everywhere, (10.0, 1.0)) == pytest.approx(8.0, abs=0.2)
