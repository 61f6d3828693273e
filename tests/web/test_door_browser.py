"""People in a browser: the first commander joins by the printed link, invites others, shuts them out."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from server.app import create_app
from server.settings import Settings


@pytest.fixture
def link(serve, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The link of the first start, at the address where the server really is."""
    host = serve(create_app(Settings(data_dir=tmp_path, login="on")))
    path = re.search(r"http://[^/]+(/join#\S+)", _printed(capsys))
    assert path is not None
    return f"http://{host}{path[1]}"


@pytest.fixture
def page(browser: Browser) -> Page:
    return browser.new_context(viewport={"width": 390, "height": 844}).new_page()


def _printed(capsys: pytest.CaptureFixture[str]) -> str:
    out = ""
    for _ in range(300):
        out += capsys.readouterr().out
        if "/join#" in out:
            break
        time.sleep(0.05)
    return out


def join(page: Page, link: str, name: str) -> None:
    page.goto(link)
    page.get_by_label("Your name").fill(name)
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Join").click()
    expect(page.get_by_label(f"Logged in as {name}")).to_be_visible()


def test_joining_logging_out_and_in_again(link: str, page: Page) -> None:
    home = link.split("/join")[0]
    page.goto(f"{home}/console?mission=x")
    expect(page).to_have_url(re.compile(r"/login\?next="))
    page.goto(link)
    page.get_by_label("Your name").fill("Ada")
    page.get_by_label("Password", exact=True).fill("short")
    page.get_by_role("button", name="Join").click()
    expect(page).to_have_url(re.compile("/join"))  # the browser says what is missing
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Join").click()
    page.get_by_label("Logged in as Ada, commander").click()
    page.get_by_role("button", name="Log out").click()
    expect(page).to_have_url(re.compile("/login"))
    page.get_by_label("Your name").fill("Ada")
    page.get_by_label("Password", exact=True).fill("wrong")
    page.get_by_role("button", name="Log in").click()
    expect(page.get_by_role("alert")).to_have_text("The name or the password is wrong; try again.")
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Log in").click()
    expect(page.get_by_label("Logged in as Ada, commander")).to_be_visible()


def test_a_used_link_and_a_foreign_way_on_are_refused(link: str, page: Page) -> None:
    home = link.split("/join")[0]
    join(page, link, "Ada")
    page.goto("about:blank")
    page.goto(link)
    page.get_by_label("Your name").fill("Eve")
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Join").click()
    expect(page.get_by_role("alert")).to_contain_text("has been used")
    page.goto(f"{home}/login?next=//elsewhere.example/x")
    page.get_by_label("Your name").fill("Ada")
    page.get_by_label("Password", exact=True).fill("correct horse")
    page.get_by_role("button", name="Log in").click()
    expect(page).to_have_url(re.compile(re.escape(home)))
    expect(page.get_by_label("Logged in as Ada, commander")).to_be_visible()


def test_a_commander_invites_gives_a_robot_its_token_and_shuts_out(
    link: str, page: Page, browser: Browser
) -> None:
    join(page, link, "Ada")
    page.get_by_label("Logged in as Ada").click()
    page.get_by_role("link", name="People").click()
    page.get_by_label("Invite somebody as").select_option("operator")
    page.get_by_role("button", name="Make a link").click()
    invitation = page.locator(".secret code").inner_text()
    other = browser.new_context().new_page()
    join(other, invitation, "Ben <b>")
    page.reload()
    expect(page.get_by_label("Role of Ben <b>")).to_have_value("operator")

    page.get_by_label("What it is for").fill("red rover")
    page.get_by_role("button", name="Make a token").click()
    expect(page.locator(".secret")).to_contain_text("told only now")
    token = page.locator(".secret code").inner_text()
    api = f"{link.split('/join')[0]}/api/v1/missions"
    shown = {"Authorization": f"Bearer {token}"}
    assert other.request.get(api, headers=shown).status == 200
    page.get_by_role("button", name="Revoke").click()
    expect(page.get_by_text("revoked")).to_be_visible()
    assert other.request.get(api, headers=shown).status == 401

    page.get_by_role("row", name="Ben <b>").get_by_role("button", name="Shut out").click()
    expect(page.get_by_text("Ben <b> (shut out)")).to_be_visible()
    expect(other).to_have_url(re.compile("/login"), timeout=60_000)
    expect(page.get_by_text("change account: Ben <b>")).to_be_visible()
    page.get_by_label("Role of Ada").select_option("viewer")
    expect(page.get_by_role("alert")).to_contain_text("Nobody would be left who is a commander")


def test_who_watches_a_mission_is_seen_and_what_one_does_is_there_for_the_other(
    link: str, page: Page, browser: Browser
) -> None:
    join(page, link, "Ada")
    home = link.split("/join")[0]
    origin = {"Origin": home}
    made = page.request.post(f"{home}/api/v1/links", data={"role": "operator"}, headers=origin).json()
    mission = {"name": "Drill", "mission_id": "drill"}
    assert page.request.post(f"{home}/api/v1/missions", data=mission, headers=origin).ok
    page.goto(f"{home}/console?mission=drill")
    page.get_by_label("Logged in as Ada").click()
    expect(page.get_by_text("Nobody else is watching this mission.")).to_be_visible()

    other = browser.new_context().new_page()
    join(other, home + made["path"], "Ben <b>")
    other.goto(f"{home}/console?mission=drill")
    expect(page.get_by_text("Also watching: Ben <b>.")).to_be_visible()
    mayday = f"{home}/api/v1/missions/drill/alerts/mayday"
    assert other.request.post(mayday, data={"text": "hurt"}, headers=origin).ok
    expect(page.locator(".alert-card").first).to_contain_text("MAYDAY from Ben <b>")
    other.close()
    expect(page.get_by_text("Nobody else is watching this mission.")).to_be_visible()
