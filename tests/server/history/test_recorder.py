"""What is recorded when, what survives, and how much it may become."""

import asyncio
import gzip
import json

import pytest

from db.errors import DatabaseError
from db.records import MissionRecord
from db.store import Store
from server.board import Board
from server.history import recorder as recorder_module
from server.history.past import Past, steps
from server.history.recorder import CHUNK_S, Recorder
from server.map_image import MapImage


def picture(version):
    return MapImage(version, 2, 2, 0.1, (0.0, 0.0), b"png%d" % version, '"x"', 1.0)


class Desk:
    """A recorder that is told the time, on a database of its own."""

    def __init__(self, store):
        self.store, self.now, self.image = store, 100.0, None
        self.board, self.past = Board(), Past(store, "m")
        self.recorder = self.anew()

    def anew(self):
        self.recorder = Recorder(self.store, "m", self.board, lambda: self.image, lambda: self.now)
        return self.recorder

    async def show(self, after_s=0.0, **values):
        self.now += after_s
        self.board.publish({key.replace("_", "/"): value for key, value in values.items()})
        await self.recorder.flush()

    async def state(self):
        found = await self.past.state_at(self.now)
        assert found is not None
        return found[1]


@pytest.fixture
def desk(tmp_path):
    def run(scenario):
        async def whole():
            store = await Store.open(tmp_path / "m.db")
            await store.missions.create_mission(MissionRecord("m", "M", "running", 0.0))
            try:
                await scenario(Desk(store))
            finally:
                await store.close()

        asyncio.run(whole())

    return run


def test_what_people_do_is_there_at_once_and_what_moves_twice_a_second(desk):
    async def scenario(desk):
        await desk.show(robot_r1={"x_m": 0.0, "name": "r1"}, trail_r1={"points_m": []})
        await desk.show(0.1, robot_r1={"x_m": 1.0, "name": "r1"}, victim_v1={"status": "confirmed"})
        assert await desk.state() == {
            "robot/r1": {"x_m": 0.0, "name": "r1"},
            "trail/r1": {"points_m": []},
            "victim/v1": {"status": "confirmed"},
        }
        await desk.show(0.4, trail_r1={"points_m": [[1, 1]]})
        assert (await desk.state())["robot/r1"]["x_m"] == 1.0
        assert (await desk.state())["trail/r1"] == {"points_m": []}
        await desk.show(9.5)
        assert (await desk.state())["trail/r1"] == {"points_m": [[1, 1]]}
        (line,) = [
            json.loads(r.body)
            for r in await desk.store.history.lines_of("m", 0)
            if '"patch":{"robot' in r.body
        ]
        assert line["patch"] == {"robot/r1": {"x_m": 1.0}}  # only what differs is written

    desk(scenario)


def test_a_chunk_is_sealed_after_half_a_minute_and_nothing_is_lost_by_it(desk):
    async def scenario(desk):
        for second in range(75):
            await desk.show(1.0, robot_r1={"x_m": float(second)})
        spans = await desk.past.spans()
        assert [span.number for span in spans] == [0, 1, 2]
        assert all(span.ends_unix_s - span.begins_unix_s <= CHUNK_S for span in spans)
        assert [whole for _, whole in [await desk.past.chunk(n) for n in range(3)]] == [True, True, False]
        assert await desk.past.chunk(3) is None
        body, _ = await desk.past.chunk(1)
        assert len(json.loads(gzip.decompress(body))["changes"]) == 29
        for second in (0, 29, 30, 31, 74):
            _, state = await desk.past.state_at(101.0 + second)
            assert state == {"robot/r1": {"x_m": float(second)}}
        assert await desk.past.state_at(100.5) is None

    desk(scenario)


def test_a_server_that_was_killed_left_its_lines(desk):
    async def scenario(desk):
        await desk.show(robot_r1={"x_m": 0.0})
        await desk.show(1.0, robot_r1={"x_m": 1.0})
        before = await desk.state()
        await desk.anew().restore()  # nobody closed the one before
        assert (await desk.past.chunk(0))[1]
        assert await desk.state() == before
        await desk.show(1.0, robot_r1=None)
        assert await desk.state() == {}
        assert [span.number for span in await desk.past.spans()] == [0, 1]

    desk(scenario)


def test_what_is_not_due_yet_is_written_at_the_end(desk):
    async def scenario(desk):
        await desk.show(trail_r1={"points_m": []})
        await desk.show(0.1, trail_r1={"points_m": [[2, 2]]})
        desk.recorder.begin()
        await desk.recorder.close()
        assert (await desk.past.state_at(1e9))[1] == {"trail/r1": {"points_m": [[2, 2]]}}
        assert (await desk.past.chunk(0))[1]

    desk(scenario)


def test_a_database_that_fails_for_a_moment_costs_resolution_but_no_change(desk, monkeypatch):
    async def scenario(desk):
        await desk.show(victim_v1={"status": "suspected"})

        async def fails(*_):
            raise DatabaseError("the disk is full.")

        with monkeypatch.context() as patch:
            patch.setattr(desk.store.history, "add_line", fails)
            await desk.show(1.0, victim_v1={"status": "confirmed"})
        assert (await desk.state())["victim/v1"] == {"status": "suspected"}
        await desk.show(1.0)
        assert (await desk.state())["victim/v1"] == {"status": "confirmed"}

    desk(scenario)


def test_each_picture_of_the_map_is_kept_with_the_line_that_names_it(desk):
    async def scenario(desk):
        for version in (1, 2, 3):
            desk.image = picture(version)
            await desk.show(2.0, map={"version": version})
        kept = [await desk.past.picture(version) for version in (1, 2, 3)]
        assert kept == [b"png1", None, None]
        await desk.show(1.0)
        assert (await desk.state())["map"] == {"version": 3}
        assert await desk.past.picture(3) == b"png3"

    desk(scenario)


def test_a_long_past_grows_more_slowly_but_people_are_never_put_off(desk, monkeypatch):
    monkeypatch.setattr(recorder_module, "STRETCH_BYTES", 1000)

    async def scenario(desk):
        desk.image = MapImage(1, 2, 2, 0.1, (0.0, 0.0), bytes(2500), '"x"', 1.0)
        await desk.show(map={"version": 1}, robot_r1={"x_m": 0.0})
        for tick in range(1, 5):
            await desk.show(0.5, robot_r1={"x_m": float(tick)}, victim_v1={"n": tick})
            assert (await desk.state())["victim/v1"] == {"n": tick}
            assert (await desk.state())["robot/r1"] == {"x_m": 4.0 if tick == 4 else 0.0}

    desk(scenario)


def test_a_clock_that_is_set_back_does_not_fold_the_past(desk):
    async def scenario(desk):
        await desk.show(victim_v1={"n": 1})
        await desk.show(-50.0, victim_v1={"n": 2})
        await desk.show(1.0, victim_v1={"n": 3})
        moments = [
            (unix_s, state["victim/v1"]["n"])
            async for chunk in desk.past.chunks()
            for unix_s, state in steps(chunk)
        ]
        assert moments == sorted(moments)
        assert [n for _, n in moments] == [1, 2, 3]

    desk(scenario)
