"""Starting and ending: a database that cannot be used, signals, and no process left behind."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
import time
from uuid import uuid4

import httpx
import psutil
import pytest

from db.errors import DatabaseError
from db.store import Store
from server.agents.process import ForkServer
from server.history.past import Past
from server.serve import run
from server.settings import Settings


@pytest.fixture
def served(tmp_path, wait_until):
    """`waymark serve` as a process with two agents and a team map; what it started is ended at the end."""
    code = "from server.cli.main import app; app()"
    words = [sys.executable, "-c", code, "serve", "--port", "0", "--login", "off", "--data"]
    environment = os.environ | {"WAYMARK_REPLY_S": "60"}  # the machine may have other things to do
    process = subprocess.Popen(
        [*words, str(tmp_path / "new" / "data")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )
    family = []
    try:
        line = process.stdout.readline()
        assert line.startswith("Waymark is opening at http://127.0.0.1:")
        url = line.split()[4]
        with httpx.Client(base_url=f"{url}/api/v1", timeout=90) as client:
            wait_until(lambda: process.poll() is not None or _answers(client), 180.0)
            client.post("/missions", json={"name": "M", "mission_id": "m"})
            for robot_id in ("r1", "r2"):
                client.post("/missions/m/robots", json={"robot_id": robot_id})
                body = {"observations": [{"seq": 0, "stamp_s": 0.0}]}
                assert (
                    client.post(f"/missions/m/robots/{robot_id}/observations", json=body).status_code == 200
                )
            family = psutil.Process(process.pid).children(recursive=True)
            assert len(family) >= 3  # who forks, and the agents
            yield process, family, url
    finally:
        for member in [*family, process]:
            if _lives(member.pid):
                os.kill(member.pid, signal.SIGKILL)
        process.communicate()


def _answers(client):
    try:
        return client.get("/health").status_code == 200
    except httpx.TransportError:
        return False


def _lives(pid):
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda sent: sent.name)
def test_no_process_is_left_behind_and_what_was_answered_is_in_the_past(served, tmp_path, wait_until, sent):
    process, family, url = served
    note = f"{url}/api/v1/missions/m/annotations/{uuid4()}"
    words = {"kind": "note", "text": "gas", "x_m": 1.0, "y_m": 2.0}
    assert httpx.put(note, json=words).is_success
    process.send_signal(sent)
    _, errors = process.communicate(timeout=60)
    wait_until(lambda: not any(_lives(member.pid) for member in family))
    assert process.returncode == {"SIGINT": 130, "SIGTERM": 143, "SIGKILL": -9}[sent.name]
    assert "Traceback" not in errors

    async def state():
        store = await Store.open(tmp_path / "new" / "data" / "waymark.db")
        found = await Past(store, "m").state_at(time.time())
        await store.close()
        return found[1]

    assert [value["text"] for key, value in asyncio.run(state()).items() if "annotation/" in key] == ["gas"]


def test_a_damaged_database_is_named_and_left_as_it_is(tmp_path):
    path = tmp_path / "waymark.db"
    path.write_bytes(b"SQLite format 3\0" + os.urandom(8000))
    before = path.read_bytes()
    with pytest.raises(DatabaseError, match=str(path)):
        run(Settings(data_dir=tmp_path, port=0))
    assert path.read_bytes() == before


def test_a_busy_port_ends_the_server_with_an_error(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(SystemExit) as ended:
        run(Settings(data_dir=tmp_path, port=taken.getsockname()[1], log_level="CRITICAL"))
    assert ended.value.code


def test_a_start_that_fails_ends_the_server_with_an_error(tmp_path, monkeypatch):
    async def fails(self):
        raise OSError("no processes left")

    monkeypatch.setattr(ForkServer, "start", fails)
    with pytest.raises(SystemExit) as ended:
        run(Settings(data_dir=tmp_path, port=0, log_level="CRITICAL"))
    assert ended.value.code
