"""The local authority: what it vouches for, what it cannot, and a server that really speaks https."""

from __future__ import annotations

import os
import socket
import ssl
import stat
import subprocess
import sys
import threading
from datetime import timedelta

import httpx
import pytest
from cryptography import x509

from server.cli.main import run
from server.settings import Settings
from server.tls import authority as module
from server.tls.authority import Authority, AuthorityError


@pytest.fixture
def authority(tmp_path):
    made = Authority(tmp_path / "tls")
    made.create(["usar.example", "192.168.1.5"])
    return made


def handshake(authority, name):
    """Shake hands over a pair of sockets as a client that trusts the authority alone and asks for a name."""
    serving = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    serving.load_cert_chain(authority.server_certificate, authority.server_key)
    asking = ssl.create_default_context(cafile=authority.certificate)
    ours, theirs = socket.socketpair()
    ours.settimeout(20)
    theirs.settimeout(20)

    def serve():
        try:
            serving.wrap_socket(ours, server_side=True).close()
        except OSError:
            ours.close()

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        asking.wrap_socket(theirs, server_hostname=name).close()
    finally:
        theirs.close()
        thread.join()


@pytest.mark.parametrize("name", ["usar.example", "192.168.1.5", "localhost", "127.0.0.1"])
def test_a_client_that_trusts_it_accepts_the_servers_names(authority, name):
    handshake(authority, name)


def test_another_name_is_not_accepted(authority):
    with pytest.raises(ssl.SSLCertVerificationError, match="mismatch"):
        handshake(authority, "bank.example")


@pytest.mark.parametrize("host", ["bank.example", "8.8.8.8"])
def test_it_vouches_for_no_other_host_even_when_its_key_signs_for_one(authority, monkeypatch, host):
    with pytest.raises(AuthorityError, match="does not vouch for"):
        authority.issue([host])
    monkeypatch.setattr(module, "_covers", lambda *_: True)
    authority.issue([host])
    with pytest.raises(ssl.SSLCertVerificationError, match="permitted subtree violation"):
        handshake(authority, host)


def test_it_takes_names_under_its_names_and_addresses_of_its_network(authority):
    authority.issue(["gate.usar.example", "192.168.1.77"])
    handshake(authority, "192.168.1.77")
    handshake(authority, "gate.usar.example")


@pytest.mark.parametrize("host", ["https://usar.example", "a b", "", "usar.example:8000", "ünï.example"])
def test_what_is_no_host_is_refused(tmp_path, host):
    with pytest.raises(AuthorityError, match="no name and no address"):
        Authority(tmp_path).create([host])


def test_keys_are_their_owners_alone(authority):
    for path in (authority.key, authority.server_key):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_the_servers_certificate_is_short_lived_and_renewed_in_time(authority, monkeypatch):
    certificate = x509.load_pem_x509_certificate(authority.server_certificate.read_bytes())
    assert certificate.not_valid_after_utc - certificate.not_valid_before_utc <= timedelta(days=31)
    before = authority.server_certificate.read_bytes()
    authority.renew()
    assert authority.server_certificate.read_bytes() == before
    monkeypatch.setattr(module, "_RENEW_BEFORE", timedelta(days=31))
    hosts = authority.hosts
    authority.renew()
    assert authority.server_certificate.read_bytes() != before
    assert authority.hosts == hosts
    handshake(authority, "usar.example")
    monkeypatch.setattr(module, "_RENEW_BEFORE", timedelta(days=400))
    with pytest.raises(AuthorityError, match="about to end"):
        authority.renew()


def test_the_command_prints_what_a_phone_scans_and_keeps_the_authority(tmp_path, capsys):
    assert run(["ca", "--host", "usar.example", "--data", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    authority = Authority(Settings(data_dir=tmp_path).tls_folder)
    assert "http://usar.example:8080/ca.crt" in said
    assert authority.fingerprint in said
    assert "█" in said or "▄" in said
    assert run(["ca", "--host", "usar.example", "--data", str(tmp_path)]) == 0
    assert authority.fingerprint in capsys.readouterr().out
    assert run(["ca", "--host", "bank.example", "--data", str(tmp_path)]) == 1
    assert "--new" in capsys.readouterr().err
    assert run(["ca", "--host", "bank.example", "--new", "--data", str(tmp_path)]) == 0


def test_https_without_an_authority_says_what_to_do(tmp_path, capsys):
    assert run(["serve", "--tls", "--port", "0", "--data", str(tmp_path)]) == 1
    assert "make one with waymark ca" in capsys.readouterr().err


def test_a_phone_gets_the_authority_and_then_speaks_https(tmp_path, wait_until):
    assert run(["ca", "--host", "127.0.0.1", "--data", str(tmp_path)]) == 0
    port, install_port = free_port(), free_port()
    words = ["serve", "--tls", "--port", str(port), "--data", str(tmp_path), "--login", "off"]
    process = subprocess.Popen(
        [sys.executable, "-m", "server.cli.main", *words],
        env={**os.environ, "WAYMARK_INSTALL_PORT": str(install_port)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        wait_until(lambda: process.poll() is not None or is_open(port))
        plain = httpx.get(f"http://127.0.0.1:{install_port}/ca.crt")
        assert plain.headers["content-type"] == "application/x-x509-ca-cert"
        context = ssl.create_default_context(cadata=plain.text)
        with httpx.Client(verify=context, base_url=f"https://127.0.0.1:{port}") as client:
            assert client.get("/api/v1/health").status_code == 200
            assert "Waymark" in client.get("/t/A1").text
        moved = httpx.get(f"http://127.0.0.1:{install_port}/t/A1", follow_redirects=False)
        assert moved.headers["location"] == f"https://127.0.0.1:{port}/t/A1"
        with pytest.raises(httpx.ConnectError, match="CERTIFICATE_VERIFY_FAILED"):
            httpx.get(f"https://127.0.0.1:{port}/")
    finally:
        process.terminate()
        assert process.wait(20) is not None


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def is_open(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
