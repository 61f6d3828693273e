"""Where nobody logs in, only this machine's own names are answered, and no other address is served."""

import socket

import httpx
import pytest
from pydantic import ValidationError
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from server.settings import Settings, is_loopback


def test_a_name_that_only_leads_here_gets_nothing(line):
    """DNS rebinding: a page elsewhere under a name of its own would pass for ours."""
    root = f"127.0.0.1:{line.control.port}"
    foreign = {"Host": f"evil.example:{line.control.port}"}
    answer = httpx.get(f"http://{root}/api/v1/missions", headers=foreign)
    assert (answer.status_code, answer.json()["error"]["code"]) == (403, "foreign_host")
    assert httpx.get(f"http://{root}/api/v1/missions", headers={"Host": "localhost"}).status_code == 200
    sock = socket.create_connection(("127.0.0.1", line.control.port))
    stream = f"ws://evil.example:{line.control.port}/api/v1{line.at}/stream"
    with pytest.raises(InvalidStatus), connect(stream, sock=sock):
        pass


def test_without_log_in_only_this_machine_is_served():
    for host in ("127.0.0.1", "127.1.2.3", "::1", "localhost"):
        assert Settings(login="off", host=host).host == host
    for host in ("0.0.0.0", "192.168.1.4", "::", "mine.example"):
        assert not is_loopback(host)
        with pytest.raises(ValidationError, match="others reach"):
            Settings(login="off", host=host)
        assert Settings(login="on", host=host).host == host
