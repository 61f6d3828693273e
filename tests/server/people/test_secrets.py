"""Passwords, tries to guess them, and roles, without a server."""

import pytest

from server.people.actor import Actor
from server.people.attempts import Attempts
from server.people.secrets import hash_password, is_password

ROLES = ("viewer", "responder", "operator", "commander")


def test_tries_wait_twice_as_long_each_time_and_are_forgotten_when_right():
    attempts = Attempts()
    for _ in range(5):
        attempts.wrong("x")
        attempts.check("x", "y")
    waits = []
    for _ in range(3):
        attempts.wrong("x")
        with pytest.raises(Exception, match="try again") as refused:
            attempts.check("x", "y")
        waits.append(refused.value.retry_after_s)
    assert waits == [4, 8, 16]
    attempts.right("x")
    attempts.check("x")


def test_passwords_are_kept_with_salts_of_their_own():
    kept = hash_password("straße 7"), hash_password("straße 7")
    assert kept[0] != kept[1]
    assert all(is_password("straße 7", k) for k in kept)
    assert not is_password("strasse 7", kept[0])


def test_a_role_may_do_what_those_before_it_may():
    for k, role in enumerate(ROLES):
        assert [Actor("x", role).may(r) for r in ROLES] == [True] * (k + 1) + [False] * (3 - k)
    assert [Actor("x", "robot").may(r) for r in ROLES] == [True, False, False, False]


def test_wrong_tries_from_elsewhere_do_not_lock_out_an_account():
    attempts = Attempts()
    for _ in range(20):
        attempts.wrong("ada from 10.0.0.9", "from 10.0.0.9")
    attempts.check("ada from 10.0.0.2", "from 10.0.0.2")
