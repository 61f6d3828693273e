"""What all who watch a mission are told: one text for those who keep up, the latest alone for others."""

import asyncio
import json

from server.board import Board
from server.broadcast import HEARTBEAT_S, Broadcast


def test_those_who_keep_up_get_the_very_same_text():
    async def play():
        board = Board()
        broadcast = Broadcast(board)
        with broadcast.listener() as one, broadcast.listener() as two:
            for x in range(3):
                board.publish({"robot/r1": {"x_m": x}})
                text = await one.next_text()
                assert await two.next_text() is text
                assert json.loads(text)["set"] == {"robot/r1": {"x_m": x}}

    asyncio.run(play())


def test_one_that_is_slow_gets_the_latest_values_in_one_text_and_holds_nobody_up():
    async def play():
        board = Board()
        broadcast = Broadcast(board)
        board.publish({"tag/A": {"x_m": 1}})
        with broadcast.listener() as slow, broadcast.listener() as quick:
            seen = []
            for x in range(4):
                board.publish({"robot/r1": {"x_m": x}, f"robot/r{x + 2}": {"x_m": x}, "tag/A": None})
                seen.append(json.loads(await quick.next_text()))
            late = json.loads(await slow.next_text())
        assert [message["set"]["robot/r1"]["x_m"] for message in seen] == [0, 1, 2, 3]
        assert late["set"]["robot/r1"] == {"x_m": 3}
        assert len(late["set"]) == 5
        assert late["delete"] == ["tag/A"]

    asyncio.run(play())


def test_many_changes_are_one_text_and_silence_is_a_heartbeat():
    async def play():
        board = Board()
        broadcast = Broadcast(board)
        with broadcast.listener() as listener:
            for x in range(100):
                board.publish({"robot/r1": {"x_m": x}})
            first = json.loads(await listener.next_text())
            assert first["set"] == {"robot/r1": {"x_m": 99}}
            async with asyncio.timeout(5 * HEARTBEAT_S):
                beat = json.loads(await listener.next_text())
            assert (beat["set"], beat["delete"]) == ({}, [])

    asyncio.run(play())


def test_nothing_runs_while_nobody_listens():
    async def play():
        board = Board()
        broadcast = Broadcast(board)
        with broadcast.listener():
            assert board.subscribers == 1
        await asyncio.sleep(0.01)
        assert board.subscribers == 0
        with broadcast.listener() as again:
            board.publish({"tag/A": {"x_m": 1}})
            assert json.loads(await again.next_text())["set"] == {"tag/A": {"x_m": 1}}

    asyncio.run(play())
