"""The story of the door: the first commander, roles, sessions, robots' tokens, and who did what."""

import contextlib
import io
import itertools
import re
import time
from uuid import uuid4

import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

PASSWORD = "correct horse"
GIVEN = "the token of the environment"
_numbers = itertools.count(1)
ROLES = ("viewer", "responder", "operator", "commander")


class People:
    """A server with log-in, and a commander called Ada."""

    def __init__(self, control, out):
        self.control = control
        link = re.search(r"http://\S+/join#(\S+)", out)
        self.ada = self.join(link[1], "Ada")

    def session(self, answer):
        assert answer.status_code == 201, answer.text
        words = answer.headers["set-cookie"]
        assert "HttpOnly" in words
        assert "SameSite=lax" in words
        self.control.forget_cookies()
        return {"Cookie": words.split(";")[0]}

    def join(self, secret, name):
        return self.session(self.call(None, "POST", "/join", secret=secret, name=name, password=PASSWORD))

    def log_in(self, name, password=PASSWORD):
        return self.session(self.call(None, "POST", "/session", name=name, password=password))

    def invite(self, role, name):
        answer = self.call(self.ada, "POST", "/links", role=role)
        return self.join(answer.json()["path"].removeprefix("/join#"), name)

    def call(self, who, method, path, **body):
        return self.control.call(method, path, body or None, headers=who)

    def code(self, who, method, path, **body):
        answer = self.call(who, method, path, **body)
        return answer.status_code, answer.json()["error"]["code"] if answer.status_code >= 400 else None


@pytest.fixture
def people(tmp_path, make_control, capfd):
    """A server of its own, for what would disturb others."""
    return People(make_control(tmp_path, login="on"), capfd.readouterr().out)


@pytest.fixture(scope="module")
def shared(tmp_path_factory, control_type):
    """One server for the tests that do not disturb each other: each has people and a mission of its own."""
    control = control_type(tmp_path_factory.mktemp("people"), login="on", robot_token=GIVEN)
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        control.start()
    yield People(control, out.getvalue())
    control.stop()


@pytest.fixture
def mission(shared):
    """The id of a mission of its own."""
    mission_id = f"m{next(_numbers)}"
    assert shared.call(shared.ada, "POST", "/missions", name="M", mission_id=mission_id).status_code == 201
    return mission_id


def test_nobody_gets_in_without_logging_in(shared):
    assert shared.code(None, "GET", "/missions") == (401, "not_logged_in")
    assert shared.code({"Authorization": "Bearer guess"}, "GET", "/missions") == (401, "wrong_token")
    assert shared.code({"Cookie": "waymark_session=guess"}, "GET", "/missions") == (401, "not_logged_in")
    assert shared.call(None, "GET", "/health").status_code == 200
    assert shared.call(shared.ada, "GET", "/session").json() == {
        "name": "Ada",
        "role": "commander",
        "login": True,
    }


def test_a_link_lets_one_person_in_once(shared):
    path = shared.call(shared.ada, "POST", "/links", role="operator").json()["path"]
    secret = path.removeprefix("/join#")
    words = {"secret": secret, "password": PASSWORD}
    assert shared.code(None, "POST", "/join", **words, name="ada") == (409, "name_taken")
    ben = shared.join(secret, "Ben")
    assert shared.call(ben, "GET", "/session").json()["role"] == "operator"
    assert shared.code(None, "POST", "/join", **words, name="Eve") == (403, "link_over")
    with shared.control.database.open("rb") as file:
        kept = file.read()
    assert secret.encode() not in kept
    assert PASSWORD.encode() not in kept


def test_accounts_sessions_and_tokens_outlive_a_restart(people, capfd):
    made = [people.call(people.ada, "POST", "/robot-tokens", label=name).json() for name in ("red", "blue")]
    people.call(people.ada, "DELETE", f"/robot-tokens/{made[1]['token_id']}")
    red, blue = ({"Authorization": f"Bearer {token['token']}"} for token in made)
    people.control.stop()
    capfd.readouterr()
    people.control.start()
    assert "/join#" not in capfd.readouterr().out  # there is a commander
    assert people.call(people.ada, "GET", "/accounts").json()["accounts"][0]["name"] == "Ada"
    assert people.call(red, "GET", "/missions").status_code == 200
    assert people.code(blue, "GET", "/missions") == (401, "wrong_token")
    again = people.log_in("ada")
    assert people.call(again, "DELETE", "/session").status_code == 204
    assert people.code(again, "GET", "/session") == (401, "not_logged_in")
    assert people.call(people.ada, "GET", "/session").status_code == 200


@pytest.mark.parametrize("role", ROLES)
def test_each_role_may_do_its_part(shared, mission, role):
    name = "Ada" if role == "commander" else f"Ben the {role}"
    who = shared.ada if role == "commander" else shared.invite(role, name)
    rank = ROLES.index(role)
    place = {"x_m": 1.0, "y_m": 2.0}
    note = f"/missions/{mission}/annotations/6f9619ff-8b86-4d01-b42d-00cf4fc964ff"
    clocks = {"phone_unix_s": 5.0, "sent_phone_unix_s": 6.0}
    for needed, method, path, body in [
        (0, "GET", f"/missions/{mission}", {}),
        (0, "POST", f"/missions/{mission}/alerts/mayday", {"text": "hurt"}),
        (0, "PUT", f"/missions/{mission}/reports/{uuid4()}", {"kind": "mayday", **clocks}),
        (1, "PUT", f"/missions/{mission}/reports/{uuid4()}", {"kind": "at", "tag_id": "A4", **clocks}),
        (0, "DELETE", f"/missions/{mission}/alerts/mayday/{name}", {}),
        (1, "PUT", note, {"kind": "note", "text": "stairs", **place}),
        (1, "POST", f"/missions/{mission}/stop", {"robots": None}),
        (2, "POST", f"/missions/{mission}/resume", {"robots": None}),
        (2, "GET", f"/missions/{mission}/audit", {}),
        (3, "GET", "/audit", {}),
        (3, "POST", "/robot-tokens", {"label": "red"}),
    ]:
        answer = shared.call(who, method, path, **body)
        assert (answer.status_code < 300) == (rank >= needed), (role, path, answer.text)
        if rank < needed:
            assert answer.json()["error"]["code"] == "role_too_low"
            assert role in answer.json()["error"]["message"]
    others = shared.code(who, "DELETE", f"/missions/{mission}/alerts/mayday/Somebody")
    assert others == ((404, "unknown_mayday") if rank else (403, "role_too_low"))


def test_whoever_is_shut_out_is_out_at_once(shared, mission):
    cem = shared.invite("operator", "Cem")
    line = shared.control.line(mission)
    accounts = shared.call(shared.ada, "GET", "/accounts").json()["accounts"]
    cem_id = next(account["account_id"] for account in accounts if account["name"] == "Cem")
    with (
        line.stream(additional_headers=shared.ada) as watching,
        line.stream(additional_headers=cem) as stream,
    ):
        watching.until(lambda s: {p["name"] for p in s.kind("person")} == {"Ada", "Cem"})
        assert shared.call(shared.ada, "PATCH", f"/accounts/{cem_id}", disabled=True).status_code == 200
        with pytest.raises(ConnectionClosed) as closed:
            stream.until(lambda s: False)
        assert closed.value.rcvd.code == 4401
        watching.until(lambda s: {p["name"] for p in s.kind("person")} == {"Ada"})
    assert shared.code(cem, "GET", "/missions") == (401, "not_logged_in")
    assert shared.code(None, "POST", "/session", name="Cem", password=PASSWORD) == (401, "wrong_password")
    ada_id = accounts[0]["account_id"]
    assert shared.code(shared.ada, "PATCH", f"/accounts/{ada_id}", role="viewer") == (409, "last_commander")


def test_a_robots_token_is_for_its_robot_until_it_is_revoked(shared, mission):
    given = {"Authorization": "Bearer " + GIVEN}
    assert shared.call(given, "POST", "/missions", name="N", mission_id="n").status_code == 201
    scope = {"mission_id": mission, "robot_id": "r1"}
    made = shared.call(shared.ada, "POST", "/robot-tokens", label="red", **scope).json()
    red = {"Authorization": f"Bearer {made['token']}"}
    at = f"/missions/{mission}"
    assert shared.call(red, "POST", f"{at}/robots", robot_id="r1").status_code == 201
    assert shared.code(red, "POST", f"{at}/robots", robot_id="r2") == (403, "other_scope")
    assert shared.code(red, "POST", "/missions/n/robots", robot_id="r1") == (403, "other_scope")
    assert shared.code(red, "POST", "/missions", name="X") == (403, "other_scope")
    assert shared.code(red, "POST", f"{at}/stop", robots=None) == (403, "not_for_robots")
    sent = {"observations": [{"seq": 0, "stamp_s": 0.0}]}
    observations = f"{at}/robots/r1/observations"
    assert shared.call(red, "POST", observations, **sent).status_code == 200
    assert shared.code(None, "POST", observations, **sent)[0] == 401
    listed = shared.call(shared.ada, "GET", "/robot-tokens").json()["tokens"][-1]
    assert "token" not in listed
    assert listed["by"] == "Ada"
    token = f"/robot-tokens/{listed['token_id']}"
    assert shared.call(shared.ada, "DELETE", token).status_code == 204
    assert shared.code(red, "POST", observations, **sent) == (401, "wrong_token")


def test_every_change_is_in_a_log_that_only_grows(shared, mission):
    dora = shared.invite("responder", "Dora")
    note = f"/missions/{mission}/annotations/6f9619ff-8b86-4d01-b42d-00cf4fc964ff"
    body = {"kind": "note", "text": "stairs", "x_m": 1.0, "y_m": 2.0}
    shared.call(dora, "PUT", note, **body)
    shared.call(shared.ada, "PUT", note, **body | {"text": "stairs up"})
    shared.call(shared.ada, "POST", f"/missions/{mission}/stop", robots=None)
    shared.code(dora, "POST", f"/missions/{mission}/resume", robots=None)  # refused: no change
    entries = shared.call(shared.ada, "GET", f"/missions/{mission}/audit").json()["entries"]
    assert [(e["by"], e["role"], e["action"], e["subject"]) for e in entries] == [
        ("Ada", "commander", "stop_robots", "all robots"),
        ("Ada", "commander", "put_annotation", note[-36:]),
        ("Dora", "responder", "put_annotation", note[-36:]),
    ]
    assert entries[1]["before"]["text"] == "stairs"
    assert (entries[1]["before"]["by"], entries[1]["after"]["by"]) == ("Dora", "Ada")
    assert time.time() - 60.0 < entries[0]["unix_s"] <= time.time()
    actions = {e["action"] for e in shared.call(shared.ada, "GET", "/audit").json()["entries"]}
    assert {"join_by_link", "make_link", "create_mission"} <= actions
    for change in ("UPDATE audit SET by = 'Eve'", "DELETE FROM audit"):
        with pytest.raises(Exception, match="only grows"):
            shared.control.sql(change)


def test_changes_of_pins_are_taken_back_unless_changed_since(shared, mission):
    note = f"/missions/{mission}/annotations/6f9619ff-8b86-4d01-b42d-00cf4fc964ff"
    body = {"kind": "note", "text": "stairs", "x_m": 1.0, "y_m": 2.0}

    def texts():
        found = shared.call(shared.ada, "GET", f"/missions/{mission}/annotations").json()["annotations"]
        return [annotation["text"] for annotation in found]

    def undo(back):
        entry = shared.call(shared.ada, "GET", f"/missions/{mission}/audit").json()["entries"][back]
        return shared.code(shared.ada, "POST", f"/missions/{mission}/audit/{entry['audit_id']}/undo")

    shared.call(shared.ada, "PUT", note, **body)
    shared.call(shared.ada, "PUT", note, **body | {"text": "no stairs"})
    assert undo(1) == (409, "changed_since")
    assert undo(0) == (204, None)
    assert texts() == ["stairs"]
    shared.call(shared.ada, "DELETE", note)
    assert texts() == []
    assert undo(0) == (204, None)
    assert texts() == ["stairs"]
    assert undo(0) == (409, "cannot_undo")
    assert shared.code(shared.ada, "POST", f"/missions/{mission}/audit/99999/undo") == (404, "unknown_change")


def test_guessing_passwords_takes_longer_and_longer(people):
    for _ in range(6):
        assert people.code(None, "POST", "/session", name="Ada", password="guess")[0] == 401
    answer = people.call(None, "POST", "/session", name="ADA", password=PASSWORD)
    assert (answer.status_code, answer.json()["error"]["code"]) == (429, "too_many_tries")
    assert int(answer.headers["Retry-After"]) >= 1
    assert people.call(people.ada, "GET", "/session").status_code == 200  # who is in stays in


def test_hostile_names_and_bodies_are_refused(shared):
    for name in ("", " Ada", "A\nB", "A  B", "x" * 61, "\u202eadA"):
        body = {"secret": "s", "name": name, "password": PASSWORD}
        assert shared.code(None, "POST", "/join", **body) == (422, "invalid"), name
    body = {"secret": "s", "name": "Ben", "password": "short"}
    assert shared.code(None, "POST", "/join", **body) == (422, "invalid")
    assert shared.code(shared.ada, "POST", "/links", role="king") == (422, "invalid")
    assert shared.code(shared.ada, "PATCH", "/accounts/none", role="viewer") == (404, "unknown_account")
    assert shared.code(shared.ada, "DELETE", "/robot-tokens/none") == (404, "unknown_token")


def test_stop_is_answered_although_it_cannot_be_noted(shared, mission):
    with shared.control.failing("audit"):
        assert shared.call(shared.ada, "POST", f"/missions/{mission}/stop", robots=None).status_code == 200


def test_the_3d_view_is_for_those_who_are_logged_in(shared, mission):
    page = f"http://127.0.0.1:{shared.control.port}/viser/{mission}"
    assert httpx.get(f"{page}/").status_code == 401
    assert httpx.get(f"{page}/", headers=shared.ada).status_code == 200
    made = shared.call(shared.ada, "POST", "/robot-tokens", label="other", mission_id="elsewhere").json()
    foreign = {"Authorization": f"Bearer {made['token']}"}
    assert httpx.get(f"{page}/", headers=foreign).status_code == 401
    with pytest.raises(InvalidStatus), connect(page.replace("http", "ws")):
        pass
