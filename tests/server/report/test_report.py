"""The report says what happened, holds all it needs, and runs nothing but its own script."""

import asyncio
import base64
import io
import json
import re
from html.parser import HTMLParser
from uuid import uuid4

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from db.photos import PhotoRecord, Pictures
from db.records import MissionRecord
from db.store import Store
from server.cli.main import run
from server.report.html import Html, duration, table, tag, text
from server.report.photos import gather

HOSTILE = '</script></style><script>window.hacked = 1</script><img src=x onerror="hacked=1"> \'&amp; ]]>'
VOID = {"meta", "br", "img"}


class Reader(HTMLParser):
    """Elements, attributes and text; scripts and styles apart."""

    def __init__(self, page):
        super().__init__()
        self.open, self.elements, self.attributes, self.words = [], [], [], []
        self.feed(page)
        self.close()

    def handle_starttag(self, name, attributes):
        self.elements.append(name)
        self.attributes += [(name, key, value) for key, value in attributes]
        if name not in VOID:
            self.open.append(name)

    def handle_endtag(self, name):
        assert self.open.pop() == name

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def jpeg(width):
    file = io.BytesIO()
    Image.new("RGB", (width, 30), (200, 30, 30)).save(file, "JPEG")
    return file.getvalue()


@pytest.fixture(scope="module")
def report(control, drive):
    """The report of a mission in which people did all that they can do."""
    line = control.open("handed-over")
    line.register(**line.words)
    for wires in drive.wires[:90]:
        line.send(wires)
    with line.stream() as stream:
        stream.until(lambda s: "map" in s.state and s.kind("victim") and s.kind("tag"))
        stream.settle()
        victim = stream.kind("victim")[0]["victim_id"]
    note = f"/annotations/{uuid4()}"
    line.call("PUT", note, {"kind": "hazard", "text": f"gas {HOSTILE}", "x_m": 1.0, "y_m": 2.0})
    gone = f"/annotations/{uuid4()}"
    line.call("PUT", gone, {"kind": "note", "text": "was here", "x_m": 1.0, "y_m": 1.0})
    line.call("DELETE", gone)
    first = {"status": "confirmed", "team": "</script><i onclick=x>"}
    for words in (first, {"live": 3, "dead": 0}, {"live": 2, "note": HOSTILE}):
        assert line.call("PATCH", f"/victims/{victim}", words).is_success
    for alert in line.get("/alerts")["alerts"]:
        line.call("POST", f"/alerts/{alert['alert_id']}/acknowledge")
    for k, of in enumerate(({"victim_id": victim}, {"x_m": 1.0, "y_m": 2.0}, {"x_m": 3.0, "y_m": 3.0})):
        words = {"photo_id": str(uuid4()), "text": f"shot {k} {HOSTILE}", **of}
        kind = {"Content-Type": "image/jpeg"}
        sent = line.call("POST", "/photos", params=words, content=jpeg(40 * (k + 1)), headers=kind)
        assert sent.is_success, sent.text
    line.call("DELETE", f"/photos/{words['photo_id']}")  # what was taken away is not handed over
    visit = {
        "team": "AUS01",
        "level": 3,
        "entered_unix_s": 1e9,
        "left_unix_s": 1e9 + 600,
        "is_finished": True,
    }
    sector = {
        "name": "North", "area_m": [[-99, -99], [99, -99], [99, 99], [-99, 99]],
        "worksite": {"worksite_id": "C-5", "hazards": HOSTILE[:120], "visits": [visit]},
    }  # fmt: skip
    line.call("PUT", f"/sectors/{uuid4()}", sector)
    line.call("POST", "/stop", {"robots": None})
    response = line.call("GET", "/report.html")
    assert response.status_code == 200
    return line, victim, response


def test_it_says_what_happened(report):
    line, victim, response = report
    words = Reader(response.text).text
    assert "Report of mission handed-over" in words
    assert f"1 {victim}: confirmed" in words
    assert "L-3 L-2 INSARAG 2020, 2027" in words  # the count of before is crossed out and stands above
    assert "D-0" not in words
    assert "Worksite C-5, sector North" in words
    assert "AUS-01 ASR3" in words
    assert re.search(r"AUS01 has searched all, \d+ live still inside|not counted yet", response.text)
    assert re.search(r"status: confirmed, team: </script>", words)
    assert "alive there: 3, dead there: 0" in words
    assert re.search(r"operator, after \d+ s", words)  # when the alert was noted
    assert "gas </script>" in words
    assert "was here" in words
    assert "removed" in words
    assert "STOP for all robots by operator." in words
    for event in line.get("/events?limit=1000")["events"]:
        assert " ".join(event["text"].split()) in words
    for found in line.get("/tags")["tags"]:
        assert found["tag_id"] in words


def test_it_needs_nothing_beside_itself_and_runs_only_its_script(report):
    _, _, response = report
    page = Reader(response.text)
    assert page.elements.count("script") == 2  # the film's data, and the player
    for name, key, value in page.attributes:
        assert not key.startswith("on"), (name, key)
        if key in ("src", "href", "action", "data", "srcset"):
            assert value.startswith(("data:image/png;base64,", "data:image/jpeg;base64,")), (name, key)
    assert not {"link", "iframe", "object", "embed", "form", "base"} & set(page.elements)
    assert "url(" not in response.text.split("<style>")[1].split("</style>")[0]
    policy = response.headers["content-security-policy"]
    assert policy.startswith("default-src 'none'; img-src data:;")
    assert "'unsafe-inline'" not in policy.split("script-src")[1]
    assert ("meta", "content", policy) in page.attributes


def test_its_film_is_the_mission(report):
    line, victim, response = report
    film = json.loads(re.search(r'id="film">(.*?)</script>', response.text)[1])
    assert film["times"] == sorted(film["times"])
    (robot,) = film["robots"]
    state = line.get("/robots/r1")["state"]
    x, y, _ = robot["poses"][-1]
    assert (x, y) == pytest.approx((state["x_m"], state["y_m"]), abs=0.3)
    assert len({tuple(pose) for pose in robot["poses"] if pose}) > 1  # recorded twice a second
    assert {each["name"] for each in film["victims"]} >= {victim}
    shown = [version for version in film["maps"] if version is not None]
    assert shown
    assert {str(version) for version in shown} <= film["pictures"].keys()


def test_an_empty_mission_has_a_report_too(control):
    words = Reader(control.open("empty").call("GET", "/report.html").text).text
    assert "No victim was seen." in words
    assert "none seen" in words


def test_the_command_writes_it_from_server_and_database(tmp_path, make_control, capsys):
    control = make_control(tmp_path)
    control.open("school")
    control.call("POST", "/missions/school/stop", {"robots": None})
    out = tmp_path / "report.html"
    assert run(["report", "school", "--out", str(out), "--server", f"http://127.0.0.1:{control.port}"]) == 0
    first = Reader(out.read_text()).text
    control.stop()
    assert run(["report", "school", "--out", str(out), "--data", str(tmp_path)]) == 0
    assert "STOP for all robots by operator." in first
    assert "STOP for all robots by operator." in Reader(out.read_text()).text
    assert run(["report", "nowhere", "--out", str(out), "--data", str(tmp_path)]) == 1
    assert "there is no mission 'nowhere'" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.part"))


@settings(max_examples=25)
@given(st.text(), st.text())
def test_whatever_comes_from_outside_is_text(word, value):
    page = tag("p", word, title=value)
    reader = Reader(page)
    assert reader.elements == ["p"]
    (attribute,) = reader.attributes
    assert attribute[2] == value.replace("\r\n", "\n").replace("\r", "\n") or attribute[2] == value
    assert Reader(table((word,), [(value,)])).elements == ["table", "thead", "tr", "th", "tbody", "tr", "td"]
    assert text(Html("<b>")) == "<b>"


def test_durations_are_told_in_words():
    assert [duration(s) for s in (0, 59.4, 60, 3599, 3600, 7260)] == [
        "0 s", "59 s", "1 min 00 s", "59 min 59 s", "1 h 00 min", "2 h 01 min",
    ]  # fmt: skip


def test_photos_are_within_the_report_with_who_and_when(report):
    _, _, response = report
    page = Reader(response.text)
    pictures = [value for name, key, value in page.attributes if (name, key) == ("img", "src")]
    sizes = []
    for address in pictures:
        head, body = address.split(",")
        assert head == "data:image/jpeg;base64"
        sizes.append(Image.open(io.BytesIO(base64.b64decode(body))).size)
    assert sizes == [(40, 30), (80, 30)]  # the victim's first; not the one that was taken away
    assert re.search(rf"shot 0 {re.escape(HOSTILE)}\. operator, \d\d:\d\d:\d\d", page.text)
    assert "At 1.0 / 2.0 m. shot 1" in page.text
    assert response.text.index("shot 0") < response.text.index("<h2>Robots")


def test_a_report_takes_as_many_photos_as_it_can_carry_those_of_victims_first(tmp_path):
    async def scenario():
        store = await Store.open(tmp_path / "m.db")
        await store.missions.create_mission(MissionRecord("m", "M", "running", 0.0))
        for k in range(6):
            of = ("v", None, None, None, None) if k == 1 else (None, None, None, 1.0, 1.0)
            photo = PhotoRecord(str(k), f"{k}", 1, 1, "", *of, "Ada", None, float(k))
            await store.photos.record_photo("m", photo, Pictures(b"", bytes(100)))
        album = await gather(store, "m", max_bytes=350)
        assert [shot.photo.photo_id for shot in album.shots] == ["1", "4", "5"]
        assert album.left_out == 3
        assert [shot.photo.photo_id for shot in album.of_others(["v"])] == ["4", "5"]
        assert len((await gather(store, "m")).shots) == 6
        await store.close()

    asyncio.run(scenario())
