"""Laws of the past: the state at any moment is what the board showed then, whatever happened between."""

import asyncio
import itertools
import json

from hypothesis import given, settings
from hypothesis import strategies as st

from db.records import MissionRecord
from db.store import Store
from server.board import Board
from server.history.changes import Change, between
from server.history.past import Past, steps
from server.history.recorder import TICK_S, Recorder

KEYS = ("robot/r1", "robot/r2", "trail/r1", "tag/A", "victim/v1", "event/7", "links", "mission", "best_map")
SLOW = ("trail", "tag", "links")  # recorded every five or ten seconds
lists = st.lists(st.sampled_from((0, 1, [1, 2])), max_size=6)
fields = st.dictionaries(st.sampled_from("abc"), st.integers(0, 3) | lists, max_size=3)
states = st.dictionaries(st.sampled_from(KEYS), fields)
published = st.dictionaries(st.sampled_from(KEYS), st.none() | fields, max_size=4)
scripts = st.lists(
    st.one_of(
        st.tuples(st.just("publish"), published),
        st.tuples(st.just("pass"), st.sampled_from((0.01, 5.0, 61.0))),
        st.tuples(st.just("flush"), st.none()),
        st.tuples(st.just("restart"), st.booleans()),
    ),
    max_size=40,
)


@given(states, states)
def test_a_change_leads_from_one_state_to_the_other(before, after):
    change = between(before, after, {**before, **after})
    state = dict(before)
    Change.of(json.loads(change.text(1.0))).apply(state)
    assert state == after
    assert bool(change) == (before != after)


class World:
    """A mission's board and its recorder on a clock of ours, restarted as often as it is told."""

    def __init__(self, store, mission_id):
        self.store, self.mission_id, self.now = store, mission_id, 1000.0
        self.shown = []  # (when, what the board showed) at every recording

    async def open(self):
        self.board = Board()
        self.recorder = Recorder(self.store, self.mission_id, self.board, lambda: None, lambda: self.now)
        await self.recorder.restore()

    async def flush(self):
        self.now += TICK_S
        await self.recorder.flush()
        state = {key: value for key, value in self.board.snapshot().items() if key != "best_map"}
        self.shown.append((self.now, state))

    async def restart(self, in_order):
        if in_order:
            self.recorder.begin()
            await self.recorder.close()
        before = self.board.snapshot()
        await self.open()
        self.board.publish(before)

    async def run(self, script):
        await self.open()
        for what, value in script:
            if what == "publish":
                self.board.publish(value)
            elif what == "pass":
                self.now += value
            elif what == "flush":
                await self.flush()
            else:
                await self.restart(value)


def fast(state):
    return {key: value for key, value in state.items() if key.partition("/")[0] not in SLOW}


async def check(world):
    past = Past(world.store, world.mission_id)
    for now, shown in world.shown:
        since, state = await past.state_at(now)
        assert since <= now
        assert fast(state) == fast(shown)
    known = [(unix_s, dict(state)) async for chunk in past.chunks() for unix_s, state in steps(chunk)]
    assert [unix_s for unix_s, _ in known] == sorted({unix_s for unix_s, _ in known})
    for unix_s, state in known[-5:]:
        assert await past.state_at(unix_s) == (unix_s, state)
    world.now += 10.0
    world.board.publish({"victim/last": {"a": 1}})
    await world.flush()
    _, state = await past.state_at(1e10)
    assert state == world.shown[-1][1]  # all of it, once what grows is due as well


def test_the_state_at_a_moment_is_what_was_shown_then(tmp_path):
    async def scenario():
        store = await Store.open(tmp_path / "m.db")
        names = (f"m{number}" for number in itertools.count())
        loop = asyncio.get_running_loop()

        async def one(script):
            mission_id = next(names)
            await store.missions.create_mission(MissionRecord(mission_id, "M", "running", 0.0))
            world = World(store, mission_id)
            await world.run(script)
            await check(world)

        @settings(max_examples=40, deadline=None)
        @given(scripts)
        def law(script):
            asyncio.run_coroutine_threadsafe(one(script), loop).result()

        await asyncio.to_thread(law)
        await store.close()

    asyncio.run(scenario())
