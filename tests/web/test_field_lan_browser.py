"""In a field network: by plain HTTP under a name, where much is held back, and with its own authority."""

from __future__ import annotations

import os
import re
import ssl
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from server.app import create_app
from server.cli.main import run
from server.settings import Settings
from server.tls.authority import Authority
from tests.web.conftest import CHROMIUM
from tests.web.field import drive_as, keep
from tests.web.trust import install

SOON_MS = 60_000
NAME = "field.lan"
PHONE: Any = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "locale": "en-GB"}
Printed = Callable[[], str]


@pytest.fixture
def abroad(browser: Browser) -> Iterator[Callable[..., Browser]]:
    """Return a function that opens a browser to which ``field.lan`` leads here."""
    opened: list[Browser] = []

    def open_abroad(**environment: str) -> Browser:
        flags = ["--no-sandbox", f"--host-resolver-rules=MAP {NAME} 127.0.0.1"]
        launch = browser.browser_type.launch
        opened.append(launch(executable_path=CHROMIUM, args=flags, env={**os.environ, **environment}))
        return opened[-1]

    yield open_abroad
    for each in opened:
        each.close()


@contextmanager
def commander(printed: str, home: str, **more: Any) -> Iterator[httpx.Client]:
    """Somebody who came first, by the link that the server printed."""
    words = {"secret": printed.split("/join#")[1].split()[0], "name": "Ada", "password": "correct horse"}
    with httpx.Client(base_url=f"{home}/api/v1", timeout=90, headers={"Origin": home}, **more) as client:
        client.post("/join", json=words).raise_for_status()
        yield client


def join(page: Page, home: str, client: httpx.Client) -> None:
    """Become a responder by a commander's invitation."""
    page.goto(home + client.post("/links", json={"role": "responder"}).json()["path"])
    page.get_by_label("Your name").fill("Kim")
    page.get_by_label("Password", exact=True).fill("battery staple")
    page.get_by_role("button", name="Join").click()
    page.wait_for_url(re.compile(r"/(phone|t|console|missions)?(\?.*)?$"))


def troubles_of(context: BrowserContext) -> list[str]:
    """What scripts and the browser complain of from now on."""
    found: list[str] = []
    context.on("weberror", lambda error: found.append(str(error.error)))
    context.on("console", lambda said: said.type == "error" and found.append(said.text))
    return found


def until(is_so: Callable[[], Any]) -> Any:
    deadline = time.monotonic() + 60.0
    while not (found := is_so()):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    return found


def test_without_https_a_phone_looks_up_leads_and_leaves_word(
    serve: Any, tmp_path: Path, robot_log: Any, abroad: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    host = serve(create_app(Settings(data_dir=tmp_path, login="on", reply_s=60.0)))
    printed = ""

    def has_printed() -> bool:
        nonlocal printed
        printed += capsys.readouterr().out
        return "/join#" in printed

    until(has_printed)
    home = f"http://{NAME}:{host.split(':')[1]}"
    with commander(printed, f"http://{host}") as client:
        field = drive_as(client, host, robot_log)
        context = abroad().new_context(**PHONE)
        troubles = troubles_of(context)
        page = context.new_page()
        join(page, home, client)
        tag, other = field.links[0]

        page.goto(f"{home}/t")  # typed
        assert page.evaluate("[isSecureContext, 'serviceWorker' in navigator, typeof crypto.randomUUID]") == [
            False,
            False,
            "undefined",
        ]
        expect(page.get_by_text("This address has no https. Leave this page open")).to_be_visible(
            timeout=SOON_MS
        )
        page.get_by_role("button", name="Scan a label").click()
        expect(page.get_by_role("alert")).to_contain_text("keeps the camera for pages with https")
        page.get_by_label("The number on the tag").fill(tag.lower())
        page.get_by_role("button", name="Where am I?").click()
        expect(page.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)

        page.goto(f"{home}/t/{tag}")  # by the link that a touch opens
        expect(page.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)
        expect(page.get_by_text("switches all that on with waymark ca")).to_be_visible(timeout=SOON_MS)
        page.get_by_role("button", name=f"Victim {field.victim}").click()
        expect(page.locator(".go .number")).to_have_text(re.compile(r"\d+ m"), timeout=SOON_MS)
        page.get_by_role("button", name="Leave word here").click()
        page.get_by_label("What is here").fill("gas")
        context.set_offline(True)  # what was said is kept, and goes out once there is signal
        page.get_by_role("button", name="Hazard").click()
        expect(page.get_by_role("button", name="One report waits to be sent")).to_be_visible()
        context.set_offline(False)
        (note,) = until(lambda: client.get("/missions/drill/annotations").json()["annotations"])
        assert (note["kind"], note["text"], note["tag_id"], note["by"]) == ("hazard", "gas", tag, "Kim")
        expect(page.get_by_text("Take care: gas.")).to_be_visible(timeout=SOON_MS)

        # live: what others do meanwhile comes to the open page
        client.delete(f"/missions/drill/annotations/{note['annotation_id']}").raise_for_status()
        expect(page.get_by_text("Take care: gas.")).to_have_count(0, timeout=SOON_MS)
        context.set_offline(True)  # the open page goes on by what it has
        page.get_by_label("The number on the tag").fill(other)
        page.get_by_role("button", name="Where am I?").click()
        expect(page.get_by_text(f"You are at tag {other}")).to_be_visible()
        assert [said for said in troubles if "Failed to load resource" not in said] == []


@contextmanager
def serving_tls(folder: Path, log: Path) -> Iterator[tuple[str, str]]:
    """``waymark serve --tls`` in a process of its own; its address, and what it printed first."""
    words = ["serve", "--tls", "--port", "0", "--data", str(folder)]
    environment = {
        **os.environ,
        "WAYMARK_INSTALL_PORT": "0",
        "WAYMARK_REPLY_S": "60",
        "PYTHONUNBUFFERED": "1",
    }
    with log.open("w") as out:
        process = subprocess.Popen(
            [sys.executable, "-m", "server.cli.main", *words], env=environment, stdout=out, stderr=out
        )
        try:
            until(lambda: process.poll() is not None or "/join#" in log.read_text())
            found = re.search(r"https://127\.0\.0\.1:(\d+)", log.read_text())
            assert found, log.read_text()
            yield found[1], log.read_text()
        finally:
            process.terminate()
            process.wait(60)


def test_with_a_local_authority_the_page_is_kept_and_opens_without_signal(
    tmp_path: Path, robot_log: Any, abroad: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["ca", "--host", NAME, "--data", str(tmp_path)]) == 0
    capsys.readouterr()
    certificate = Authority(Settings(data_dir=tmp_path).tls_folder).certificate
    install(tmp_path, certificate)
    with serving_tls(tmp_path, tmp_path / "log") as (port, printed):
        trusted = ssl.create_default_context(cafile=str(certificate))
        here, home = f"https://127.0.0.1:{port}", f"https://{NAME}:{port}"
        until(lambda: is_up(here, trusted))
        with commander(printed, here, verify=trusted) as client:
            tag = drive_as(client, NAME, robot_log).links[0][0]
            context = abroad(HOME=str(tmp_path)).new_context(**PHONE)
            troubles = troubles_of(context)
            page = context.new_page()
            join(page, home, client)
        page.goto(f"{home}/phone")
        assert page.evaluate("isSecureContext")
        keep(page)
        page.close()
    cold = context.new_page()  # the server is gone, the phone starts cold
    cold.goto(f"{home}/t/{tag}")
    expect(cold.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)
    expect(cold.get_by_text("No signal.")).to_be_visible(timeout=SOON_MS)
    expect(cold.get_by_text("This address has no https")).to_have_count(0)
    assert [said for said in troubles if "Failed to load resource" not in said] == []


def is_up(home: str, trusted: Any) -> bool:
    try:
        return httpx.get(f"{home}/api/v1/health", verify=trusted).is_success
    except httpx.HTTPError:
        return False
