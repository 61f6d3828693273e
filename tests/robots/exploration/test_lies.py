"""Liars under the mission's own seal, moved and stale tags: never much worse than without tags.

Liars under another seal change nothing at all.
"""

from dataclasses import replace

import numpy as np
import pytest

from robots.config import AgentConfig, DeploymentConfig, PlanningConfig, TagMemoryConfig
from robots.sim.arena.config import ArenaConfig
from robots.sim.arena.ground import ground_of
from robots.sim.arena.result import ArenaResult
from robots.sim.arena.run import Arena
from robots.sim.scenario import ScenarioConfig
from robots.tags.marks import goal_mark
from robots.tags.memory import CLOSED, SIDE, TagMemory
from robots.tags.sealed import close_memory, open_memory

SHARE = 0.95
MAP, SEEDS = "office:120", range(6, 12)
EVERYWHERE = TagMemory(np.full((SIDE, SIDE), CLOSED, np.uint8))
AROUND = TagMemory(np.full((11, 11), CLOSED, np.uint8))
OURS, THEIRS = "a1" * 8, "b2" * 8
LIAR = replace(EVERYWHERE, passes=tuple(goal_mark(f"liar-{k}", 9, 0, 3.0 * k, -2.0 * k) for k in range(4)))


def arena(seed: int, magazine: int = 100, communication: str = "tags", key: str = "") -> Arena:
    agent = AgentConfig(
        tag_memory=TagMemoryConfig(key=key),
        planning=PlanningConfig(explore="waymark", communication=communication),
        deployment=DeploymentConfig(magazine=magazine),
    )
    told = ScenarioConfig(
        MAP, robots=2, seed=seed, poses="truth", victims=0, agent_config=agent, base_tag=magazine > 0
    )
    config = ArenaConfig(told, "at once", reader_m=4.0, limit_s=400.0, until=0.95)
    return Arena(config, ground_of(config.scenario))


def lie(arena: Arena, memory: TagMemory, key: str = "") -> None:
    """Leave tags in the whole building that hold one memory under a seal."""
    world = arena.ground.world
    rows, columns = np.nonzero(world.reachable(0.3))
    for k in range(0, len(rows), max(1, len(rows) // 25)):
        x, y = ((at[k] + 0.5) * world.resolution_m for at in (columns, rows))
        tell(arena, f"LIE{k}", (world.origin_m[0] + x, world.origin_m[1] + y), memory, key)


def tell(arena: Arena, tag_id: str, place: tuple[float, float], memory: TagMemory, key: str = "") -> None:
    """Leave a tag with a memory under a seal."""
    config = arena.robots[0].scout.config.tag_memory
    arena.field.drop(tag_id, *place)
    record = close_memory(memory, 1, tag_id, bytes.fromhex(key), config.room_bytes)
    arena.field.write(tag_id, record, *place)


def seconds(arena: Arena) -> float:
    return seconds_of(arena.play())


def seconds_of(result: ArenaResult) -> float:
    found = result.reached_s(SHARE)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def without_tags() -> float:
    return float(np.mean([seconds(arena(seed, 0, "none")) for seed in SEEDS]))


@pytest.mark.parametrize("memory", [EVERYWHERE, LIAR], ids=["all covered", "all covered and taken"])
def test_tags_that_lie_make_robots_hardly_slower_than_no_tags(without_tags, memory):
    taken = []
    for seed in SEEDS:
        run = arena(seed)
        lie(run, memory)
        taken.append(seconds(run))
    assert np.mean(taken) <= without_tags / SHARE


def test_tags_of_an_earlier_mission_that_were_moved_make_robots_hardly_slower(without_tags):
    taken = []
    for seed in SEEDS:
        earlier, run = arena(seed), arena(seed)
        earlier.play()
        written = [tag for tag in earlier.field.tags if tag.memory][:30]
        for k, (tag, other) in enumerate(zip(written, reversed(written), strict=True)):
            said = open_memory(other.memory, other.tag_id, b"").memory
            tell(run, f"OLD{k}", (tag.x_m, tag.y_m), said)
        taken.append(seconds(run))
    assert np.mean(taken) <= without_tags / SHARE


def ends(seed: int, memory: TagMemory, sealed_by: str) -> list[tuple[float, float, float]]:
    """Return where robots of a mission with a key end, and by how much way, among tags that hold a memory."""
    run = arena(seed, key=OURS)
    lie(run, memory, sealed_by)
    seconds(run)
    return [(robot.pose.x, robot.pose.y, robot.driven_m) for robot in run.robots]


def test_what_a_strangers_seal_tells_changes_nothing():
    seed = SEEDS[0]
    silent, lied = (ends(seed, memory, THEIRS) for memory in (TagMemory.empty(), AROUND))
    assert lied == silent
    assert ends(seed, AROUND, OURS) != silent  # it would, were it believed
