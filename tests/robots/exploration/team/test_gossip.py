"""Ground told among robots: nothing that is lost on the way is lost for good."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import BodyConfig, MappingConfig, PlanningConfig
from robots.exploration.team.gossip import Gossip
from robots.exploration.team.team_ground import FREE, OCCUPIED, UNKNOWN, TeamGround, tiles_of, unpacked
from robots.exploration.team.team_message import (
    LATTICE_CELL_M,
    MAX_TILES,
    TILE_BYTES,
    TILE_CELLS,
    Patch,
    Tile,
    decode_message,
    encode_message,
)
from robots.mapping.fused import FusedGrid
from robots.planning.plan_grid import plan_grid
from robots.se2 import Pose2

ALL_FREE, ALL_OCCUPIED = bytes([0b01010101]) * TILE_BYTES, bytes([0b10101010]) * TILE_BYTES
HERE = Pose2()


def say(speaker: Gossip, now_s: float):
    return decode_message(encode_message(speaker.say(now_s, now_s, HERE, None)))


def ground_of(gossip: Gossip, robot_id: str):
    patch = gossip.ground.news(robot_id, 0, 2**31, 10**6)
    return {} if patch is None else {(t.row, t.column): (t.version, t.cells) for t in patch.tiles}


@given(
    st.lists(
        st.tuples(st.sampled_from("abc"), st.integers(0, 5), st.binary(min_size=1, max_size=1)), max_size=25
    ),
    st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=25),
)
@settings(max_examples=60, deadline=None)
def test_after_any_loss_a_few_messages_in_reach_make_all_know_all(seen, losses):
    team = {name: Gossip(name) for name in "abc"}
    now_s = 0.0
    for k, (name, place, value) in enumerate(seen):
        team[name].ground.note(name, {(place, 0): value * TILE_BYTES})
        message = say(team[name], now_s)
        lost = losses[k] if k < len(losses) else (True, True, True)
        for other, gone in zip("abc", lost, strict=True):
            if other != name and not gone:
                assert team[other].hear(now_s, message) is None
        now_s += 1.0
    for _ in range(8):
        said = {name: say(speaker, now_s) for name, speaker in team.items()}
        for name, listener in team.items():
            for other, message in said.items():
                if other != name:
                    listener.hear(now_s, message)
        now_s += 1.0
    for name in "abc":
        assert ground_of(team["a"], name) == ground_of(team["b"], name) == ground_of(team["c"], name)
    assert not any(message.patches for message in said.values())  # and then there is silence


def test_a_third_one_carries_what_two_that_never_meet_have_seen():
    a, b, c = Gossip("a"), Gossip("b"), Gossip("c")
    a.ground.note("a", {(k, 0): ALL_FREE for k in range(150)})
    now_s = 0.0
    for first, second in ((a, b), (b, c)):
        for _ in range(10):
            said = say(first, now_s), say(second, now_s)
            first.hear(now_s, said[1])
            second.hear(now_s, said[0])
            assert sum(len(p.tiles) for m in said for p in m.patches) <= 2 * MAX_TILES
            now_s += 1.0
        now_s += 60.0
    assert ground_of(c, "a") == ground_of(a, "a")
    assert len(ground_of(c, "a")) == 150


def test_others_ground_is_passed_on_only_to_those_who_lack_it():
    """Where everybody hears everybody nobody repeats what all have heard."""
    team = {name: Gossip(name) for name in "abc"}
    for step in range(12):
        now_s = float(step)
        for name, speaker in team.items():
            speaker.ground.note(name, {(step, ord(name)): ALL_FREE})
        said = {name: say(speaker, now_s) for name, speaker in team.items()}
        for name, message in said.items():
            assert {patch.origin for patch in message.patches} <= {name}
            for other in team.keys() - {name}:
                team[other].hear(now_s, message)


def test_twice_late_and_from_elsewhere():
    a, b = Gossip("a"), Gossip("b")
    a.ground.note("a", {(0, 0): ALL_FREE})
    a.hear(0.0, say(b, 0.0))
    old = say(a, 0.0)
    a.ground.note("a", {(0, 0): ALL_OCCUPIED})
    new = say(a, 1.0)
    for message in (new, old, new):
        assert b.hear(2.0, message) is None
    assert ground_of(b, "a") == ground_of(a, "a")
    assert b.heard["a"].message == new
    assert "speaks as b" in b.hear(2.0, replace(new, robot_id="b"))
    ahead = replace(new, known=(*new.known, ("b", 99)), number=50)
    assert "yet to see" in b.hear(2.0, ahead)
    assert b.heard["a"].message == new


def test_a_crowd_is_bounded():
    listener = Gossip("me")
    for k in range(200):
        other = Gossip(f"r{k}")
        other.ground.note(f"r{k}", {(0, 0): ALL_FREE})
        other.hear(0.0, say(listener, 0.0))
        doubt = listener.hear(0.0, say(other, 0.0))
    assert "more than 128" in doubt
    encode_message(listener.say(1.0, 1.0, HERE, None))


def test_there_is_an_end_to_the_ground_that_is_kept(monkeypatch):
    monkeypatch.setattr("robots.exploration.team.team_ground.MOST_IN_ALL", 3)
    listener, talker = Gossip("me"), Gossip("a")
    talker.hear(0.0, say(listener, 0.0))
    talker.ground.note("a", {(k, 0): ALL_FREE for k in range(5)})
    assert "no room" in listener.hear(0.0, say(talker, 0.0))
    assert len(ground_of(listener, "a")) == 3
    talker.ground.note("a", {(0, 0): ALL_OCCUPIED})
    talker.hear(1.0, say(listener, 1.0))
    assert listener.hear(1.0, say(talker, 1.0)) is None
    assert ground_of(listener, "a")[0, 0] == (6, ALL_OCCUPIED)


def drawn(cells) -> FusedGrid:
    fused = FusedGrid(0.05)
    fused.put("all", 0, Pose2(), cells.astype(np.int16))
    return fused


def test_own_eyes_overrule_and_the_rest_is_as_the_more_have_seen_it():
    ground = TeamGround()
    for name, cells in (("a", ALL_FREE), ("b", ALL_OCCUPIED), ("c", ALL_OCCUPIED)):
        ground.take(Patch(name, 0, 1, (Tile(0, 0, 1, cells),)))
    own = np.zeros((40, 40))
    own[:20, :20], own[20:, 20:] = -20, 30
    seen = ground.overlaid(drawn(own), 2, Pose2(), MappingConfig())
    x0, y0 = (round(-o / 0.05) for o in seen.origin)
    inside = seen.cells[y0 : y0 + 64, x0 : x0 + 64]
    assert (inside[:20, :20] == -20).all()
    assert (inside[20:40, 20:40] == 30).all()
    assert (inside[:20, 20:] == MappingConfig().occupied_logodds).all()
    ground.take(Patch("c", 1, 2, (Tile(0, 0, 2, ALL_FREE),)))
    seen = ground.overlaid(drawn(own), 2, Pose2(), MappingConfig())
    assert (seen.cells[y0 : y0 + 20, x0 + 20 : x0 + 64] == -MappingConfig().miss_logodds).all()


def test_a_wall_that_others_saw_stays_one_where_own_eyes_see_the_ground_beside_it():
    """Half of a cell of the plan is seen from the side: the wall in its other half is no edge."""
    ground, mapping = TeamGround(), MappingConfig()
    ground.take(Patch("a", 0, 1, (Tile(0, 0, 1, ALL_OCCUPIED),)))
    own = np.zeros((40, 40))
    own[:, :9] = -20  # the tenth column is the other half
    seen = ground.overlaid(drawn(own), 2, Pose2(), mapping)
    grid = plan_grid(seen, BodyConfig(), PlanningConfig(), mapping, np.zeros((0, 3)))
    assert grid.cells[grid.cell_of(0.425, 0.5)] == OCCUPIED


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.1, 3.1), st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_ground_comes_over_within_a_cell_whatever_the_frames(x, y, theta, seed):
    """Blocks of half a metre, seen in one turned frame and looked up in another: moved by a cell at most."""
    blocks = np.random.default_rng(seed).integers(0, 3, (8, 8))
    cells = np.kron(np.array([0, -20, 20])[blocks], np.ones((10, 10)))
    fused, mission_from_map = drawn(cells), Pose2(x, y, theta)
    found = tiles_of(fused, mission_from_map, np.array([2.0, 2.0]), np.inf, MappingConfig())
    middles = (np.stack(np.meshgrid(range(8), range(8)), axis=-1).reshape(-1, 2) + 0.5) * 0.5
    for (u, v), (px, py) in zip(middles, mission_from_map.transform(middles), strict=True):
        column, row = (int(np.floor(value / LATTICE_CELL_M)) for value in (px, py))
        tile = unpacked(found[row // TILE_CELLS, column // TILE_CELLS])
        state = tile[row % TILE_CELLS, column % TILE_CELLS]
        assert state == blocks[int(v / 0.5), int(u / 0.5)]
    ground = TeamGround()
    tiles = tuple(Tile(*key, k + 1, cells) for k, (key, cells) in enumerate(found.items()))
    ground.take(Patch("a", 0, len(tiles), tiles))
    there = Pose2(-1.0, 2.0, 0.7)
    seen = ground.overlaid(drawn(np.zeros((2, 2))), 2, there, MappingConfig())
    for (u, v), (px, py) in zip(
        middles, (there.inverse() @ mission_from_map).transform(middles), strict=True
    ):
        value = seen.cells[int((py - seen.origin[1]) / 0.05), int((px - seen.origin[0]) / 0.05)]
        state = UNKNOWN if value == 0 else OCCUPIED if value > 0 else FREE
        assert state == blocks[int(v / 0.5), int(u / 0.5)]


def test_ground_beyond_all_reason_is_passed_on_and_not_planned_over():
    ground = TeamGround()
    ground.take(Patch("a", 0, 1, (Tile(30_000, 30_000, 1, ALL_FREE),)))
    own = drawn(np.full((10, 10), -20))
    assert ground.overlaid(own, 2, Pose2(), MappingConfig()) is own
    assert ground.news("a", 0, 1, 9).tiles[0].row == 30_000


@pytest.mark.parametrize("room", [1, 2, 5])
def test_a_part_is_the_oldest_and_says_how_far_it_reaches(room):
    ground, other = TeamGround(), TeamGround()
    ground.note("a", {(k, k): ALL_FREE for k in range(5)})
    ground.note("a", {(0, 0): ALL_OCCUPIED})
    for _ in range(6):
        patch = ground.news("a", other.known.get("a", 0), 2**31, room)
        if patch is None:
            break
        other.take(patch)
    assert patch is None
    assert other.known == ground.known == {"a": 6}
    assert other.news("a", 0, 9, 9).tiles == ground.news("a", 0, 9, 9).tiles
