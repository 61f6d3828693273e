"""The board: the latest value of every key, and subscribers that are told of changes, not of history."""

import asyncio
import json

from server.board import Board


def test_a_slow_subscriber_gets_the_latest_only():
    async def play():
        board = Board()
        board.publish({"robot/r1": {"x_m": 0.0}})
        with board.subscribe() as slow, board.subscribe() as quick:
            seen = []
            for x in range(1, 1001):
                board.publish({"robot/r1": {"x_m": float(x)}, "robot/r2": {"x_m": float(-x)}})
                seen.append(await quick.next_keys(None))
            assert seen == [["robot/r1", "robot/r2"]] * 1000
            there, gone = board.changes_text(await slow.next_keys(None))
            assert json.loads(there) == {"robot/r1": {"x_m": 1000.0}, "robot/r2": {"x_m": -1000.0}}
            assert json.loads(gone) == []
            assert await slow.next_keys(0.01) == []
        assert board.subscribers == 0

    asyncio.run(play())


def test_what_does_not_change_is_not_told():
    async def play():
        board = Board()
        with board.subscribe() as subscription:
            board.publish({"tag/A": {"x_m": 1.0}, "tag/B": None})
            assert await subscription.next_keys(0.01) == ["tag/A"]
            board.publish({"tag/A": {"x_m": 1.0}, "tag/B": None})
            assert await subscription.next_keys(0.01) == []

    asyncio.run(play())


def test_a_key_can_go_and_come_back_unseen():
    async def play():
        board = Board()
        board.publish({"tag/A": {"x_m": 1.0}, "tag/B": {"x_m": 2.0}})
        with board.subscribe() as subscription:
            board.publish({"tag/A": None, "tag/B": None})
            board.publish({"tag/B": {"x_m": 3.0}})
            there, gone = board.changes_text(await subscription.next_keys(None))
        assert json.loads(there) == {"tag/B": {"x_m": 3.0}}
        assert json.loads(gone) == ["tag/A"]
        assert json.loads(board.snapshot_text()) == board.snapshot() == {"tag/B": {"x_m": 3.0}}

    asyncio.run(play())


def test_iterating_gives_values_and_deleted_keys():
    async def play():
        board = Board()
        board.publish({"tag/A": {"x_m": 1.0}})
        with board.subscribe() as subscription:
            board.publish({"tag/A": None, "tag/B": {"x_m": 2.0}})
            assert await anext(subscription) == ({"tag/B": {"x_m": 2.0}}, ["tag/A"])

    asyncio.run(play())


def test_of_kind_is_no_prefix_of_another_kind():
    board = Board()
    board.publish({"tag/A": {"n": 1}, "tagged/B": {"n": 2}, "tag/B": {"n": 3}})
    assert board.of_kind("tag") == [{"n": 1}, {"n": 3}]
