"""Tags with copies, on the phone: told to whoever touches one, whatever the phone's clock says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from robots.routes.pace import is_too_far
from server.app import create_app
from server.settings import Settings
from tests.server.api.test_touches import PRECISE, along_a_corridor
from tests.web.conftest import Serve
from tests.web.field import START

SOON_MS = 60_000
JUDGE = """async ([tags, touches]) => {
  const { judged } = await import("/static/phone/pace.js");
  const { state } = await import("/static/phone/state.js");
  state.roads = { tags, numbers: new Map(tags.map(({ tag_id }, k) => [tag_id, k])) };
  let seen = [];
  return touches.map((now) => {
    const found = judged(seen, { mission: "m", ...now });
    seen = found.seen;
    return found.odd && [found.odd.tag, found.odd.before];
  });
}"""
FAR = """async (cases) => {
  const { isTooFar } = await import("/static/phone/pace.js");
  return cases.map((numbers) => isTooFar(...numbers));
}"""
DAYS_S = 3 * 86_400.0


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A mission with the tags A0, A1 and A2 at 0, 4 and 30 m of a corridor."""
    serve = Serve()
    host = serve(create_app(Settings(data_dir=tmp_path_factory.mktemp("twins"), login="off", reply_s=60.0)))
    with httpx.Client(base_url=f"http://{host}/api/v1", timeout=90) as client:
        client.post("/missions", json={"name": "Copies", "mission_id": "twins"}).raise_for_status()
        words = {"robot_id": "r1", "start_pose": START, "config": PRECISE}
        client.post("/missions/twins/robots", json=words).raise_for_status()
        body = {"observations": along_a_corridor()}
        client.post("/missions/twins/robots/r1/observations", json=body).raise_for_status()
        while len(client.get("/missions/twins/pocket").json()["tags"]) < 3:
            pass
    yield f"http://{host}"
    serve.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    context = browser.new_context(locale="en-GB", viewport={"width": 390, "height": 844})
    yield context.new_page()
    context.close()


def of_tags(api: httpx.Client) -> list[dict[str, Any]]:
    return [alert for alert in api.get("/alerts").json()["alerts"] if alert["kind"] == "tag"]


def at_tags(api: httpx.Client) -> list[dict[str, Any]]:
    return [said["body"] for said in api.get("/reports").json()["reports"] if said["kind"] == "at"]


def test_a_copy_is_told_to_whoever_touches_it_and_to_the_commander(home: str, page: Page) -> None:
    told = page.locator("main").get_by_role("alert")

    def touch(tag: str) -> None:
        page.goto(f"{home}/t/{tag}")
        expect(page.get_by_text(f"You are at tag {tag}")).to_be_visible(timeout=SOON_MS)
        expect(page.get_by_text("Data of")).to_be_visible(timeout=SOON_MS)

    with httpx.Client(base_url=f"{home}/api/v1/missions/twins", timeout=90) as api:
        touch("A0")
        page.get_by_label("The number on the tag").fill("A2")
        page.get_by_role("button", name="Where am I?").click()
        expect(page.get_by_text("You are at tag A2")).to_be_visible(timeout=SOON_MS)
        expect(told).to_have_count(0)  # whoever looks a tag up is not there
        touch("A1")
        expect(told).to_have_count(0)
        touch("A2")  # 396 m further
        expect(told).to_contain_text("This phone read tag A1 ")
        expect(told).to_contain_text("there are two tags A2, or one of the two was moved")
        while not (alerts := of_tags(api)):
            page.wait_for_timeout(100)
        (alert,) = alerts
        assert alert["tag_id"] == "A2"
        assert alert["text"].startswith("operator touched tag A2 ")
        reported = at_tags(api)
        (walk,) = [body for body in reported if body.get("from_tag") == "A0"]
        assert (walk["tag_id"], walk["after_s"] >= 0.0) == ("A1", True)
        page.reload()
        expect(page.get_by_text("You are at tag A2")).to_be_visible(timeout=SOON_MS)
        expect(told).to_have_count(0)  # a page that is loaded again was not touched
        page.go_back()
        expect(page.get_by_text("You are at tag A1")).to_be_visible(timeout=SOON_MS)
        expect(page.get_by_text("Data of")).to_be_visible(timeout=SOON_MS)
        assert at_tags(api) == reported  # nor is anybody at a tag whose page is gone back to
        touch("A0")  # where it can have come to from A1: it was A2 that was odd
        expect(told).to_have_count(0)
        assert len(of_tags(api)) == 1


def test_the_phone_judges_as_the_server_does(page: Page, home: str) -> None:
    rng = np.random.default_rng(5)
    cases = [[float(v) for v in row] for row in rng.uniform((0, 0, -5), (200, 4, 40), (400, 3))]
    page.goto(f"{home}/static/logo.svg")
    found = page.evaluate(FAR, cases)
    assert found == [is_too_far(*case) for case in cases]
    assert 20 < sum(found) < 380


def test_no_walker_is_doubted_whatever_the_clock_does_and_a_copy_is(page: Page, home: str) -> None:
    """Fifty people walk and run from tag to tag; clocks are days off, are learnt and are set on the way."""
    rng = np.random.default_rng(7)
    page.goto(f"{home}/static/logo.svg")
    for _ in range(50):
        places = rng.uniform(0, 150, (12, 2))
        tags = [
            {"tag_id": f"T{k}", "x_m": x, "y_m": y, "sd_m": 0.2, "notice": ""}
            for k, (x, y) in enumerate(places.tolist())
        ]
        now, error, knows = 1.79e9, float(rng.uniform(-DAYS_S, DAYS_S)), False
        touches = []
        for k in range(12):
            if k:
                now += float(np.hypot(*(places[k] - places[k - 1]))) / float(rng.uniform(0.5, 5.0))
            if rng.random() < 0.2:
                error, knows = 0.0 if rng.random() < 0.5 else float(rng.uniform(-DAYS_S, DAYS_S)), True
            knows = knows or bool(rng.random() < 0.3)
            touches.append({"tag": f"T{k}", "phone_s": now - error, "offset_s": error if knows else None})
        assert page.evaluate(JUDGE, [tags, touches]) == [None] * 12
    tags = [
        {"tag_id": name, "x_m": x, "y_m": 0.0, "sd_m": 0.2, "notice": notice}
        for name, x, notice in (("A", 0.0, ""), ("B", 6.0, ""), ("C", 90.0, ""), ("D", 95.0, "moved"))
    ]

    def judge(*touched: tuple[str, float]) -> list[Any]:
        touches = [{"tag": tag, "phone_s": s - DAYS_S, "offset_s": None} for tag, s in touched]
        found: list[Any] = page.evaluate(JUDGE, [tags, touches])
        return found

    assert judge(("A", 0), ("C", 5), ("B", 10)) == [None, ["C", "A"], None]  # C is the copy
    assert judge(("A", 0), ("C", 5), ("C", 6)) == [None, ["C", "A"], ["C", "A"]]
    assert judge(("A", 0), ("D", 5)) == [None, None]  # that one is doubted already
    assert judge(("C", 0), ("A", 5), ("B", 9)) == [None, ["A", "C"], None]  # C was: A and B agree
