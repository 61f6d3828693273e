"""Victims: what robots measure changes them, what a person said stays, and nobody vanishes by a restart."""

import asyncio

import numpy as np

from db.records import MissionRecord
from db.store import Store
from robots.team import TeamVictim
from server.board import Board
from server.mission.alerts import Alerts
from server.mission.events import Events
from server.mission.victims import Victims


def seen(victim_id, robots=("r1",), x_m=1.0):
    return TeamVictim(victim_id, x_m, 2.0, np.eye(2) * 0.1, 0.8, 3, robots, 1.0, 2.0)


def play(tmp_path, scenario):
    async def whole():
        store = await Store.open(tmp_path / "w.db")
        try:
            await store.missions.create_mission(MissionRecord("m", "M", "running", 0.0))
            board = Board()
            events = Events(store, "m", board)
            alerts = Alerts(store, "m", board, events)
            await scenario(Victims(store, "m", board, events, alerts), board, store)
        finally:
            await store.close()

    asyncio.run(whole())


def test_a_victim_that_turned_out_to_be_another_goes(tmp_path):
    async def scenario(victims, board, store):
        await victims.take([seen("v1"), seen("v2", x_m=9.0)], set())
        await victims.take([seen("v2", x_m=9.0)], set())
        assert [victim.victim_id for victim in victims.all()] == ["v2"]
        assert [value["victim_id"] for value in board.of_kind("victim")] == ["v2"]
        assert [victim.victim_id for victim in await store.findings.victims_of("m")] == ["v2"]
        assert len(board.of_kind("event")) == 2  # each was news once

    play(tmp_path, scenario)


def test_a_judged_victim_and_one_whose_robot_is_absent_stay(tmp_path):
    async def scenario(victims, board, store):
        await victims.take([seen("v1"), seen("v2", ("r1", "r2")), seen("v3")], set())
        await victims.say("v3", {"status": "reached"}, "Ada")
        await victims.take([], {"r2"})
        assert [victim.victim_id for victim in victims.all()] == ["v2", "v3"]
        await victims.take([seen("v2")], set())
        assert len([event for event in board.of_kind("event") if event["kind"] == "victim_seen"]) == 3

    play(tmp_path, scenario)


def test_what_a_person_says_meanwhile_is_not_lost(tmp_path):
    async def scenario(victims, board, store):
        await victims.take([seen("v1")], set())
        await asyncio.gather(
            victims.take([seen("v1", x_m=5.0)], set()),
            victims.say("v1", {"status": "confirmed", "note": "waves"}, "Ada"),
        )
        for victim in (victims.get("v1"), (await store.findings.victims_of("m"))[0]):
            assert (victim.said.status, victim.said.note, victim.said.by, victim.place.x_m) == (
                "confirmed",
                "waves",
                "Ada",
                5.0,
            )
        assert board.get("victim/v1")["status"] == "confirmed"

    play(tmp_path, scenario)
