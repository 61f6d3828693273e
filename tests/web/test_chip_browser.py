"""Web NFC with a stubbed NDEFReader: tags touched, words left in chips beside what robots sealed there."""

from __future__ import annotations

import random
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from fastapi import FastAPI
from playwright.sync_api import Browser, Page, expect

from robots.tags.chip import CHIPS, Chip, read_chip
from robots.tags.content import encode_memory
from robots.tags.marks import MAX_TEXT, Note, Notes, victim_mark
from robots.tags.memory import TagMemory
from robots.tags.reader import SimulatedTag, read_tag, write_tag
from robots.tags.record import seal
from robots.tags.sealed import open_memory, unsealed_notes
from server.benchmarks.nfc_stub import NFC
from server.mission.chip_notes import chip_note_id
from web.mount import mount_web

KEY, TAG = b"mission", "A4"
LINK = f"https://usar.example/t/{TAG}"
SOON_MS = 60_000
WRITE = """async (cases) => {
  const { withNote } = await import("/static/phone/chip_writer.js");
  return cases.map(({ payload, author, texts }) => {
    let bytes = Uint8Array.from(payload);
    for (const text of texts) {
      try { bytes = withNote(bytes, author, text); } catch (error) { return error.why; }
    }
    return [...bytes];
  });
}"""


@pytest.fixture
def scripts(browser: Browser, serve: Any) -> Iterator[Page]:
    app = FastAPI()
    mount_web(app)
    context = browser.new_context()
    page = context.new_page()
    page.goto(f"http://{serve(app)}/static/logo.svg")
    yield page
    context.close()


def memory(rng: random.Random) -> TagMemory:
    """What a robot may have left: a victim or two, and what somebody wrote."""
    victims = tuple(victim_mark(f"v{k}", 0.5, 60.0 * k, 1.0, -2.0) for k in range(rng.randint(0, 2)))
    notes = Notes((Note(rng.randint(1, 9), "Ann", "door jammed"),)) if rng.random() < 0.5 else Notes()
    empty = TagMemory.empty()
    return TagMemory(empty.cells, (), tuple(sorted(victims, reverse=True)), notes)


def chip_of(rng: random.Random, chip: Chip) -> SimulatedTag:
    tag = SimulatedTag.formatted(chip, LINK)
    for revision in range(rng.randint(0, 3)):
        room = read_tag(tag).room_bytes
        write_tag(tag, seal(encode_memory(memory(rng).fit(room)), revision, TAG, KEY))
    return tag


def payload_of(tag: SimulatedTag) -> bytes:
    _, layout = read_chip(tag.read())
    return tag.read()[layout.start : layout.start + layout.size]


def with_payload(tag: SimulatedTag, payload: bytes) -> SimulatedTag:
    data, (_, layout) = bytearray(tag.read()), read_chip(tag.read())
    assert len(payload) == layout.size
    data[layout.start : layout.start + layout.size] = payload
    return SimulatedTag(tag.chip, bytes(data))


def test_words_are_added_to_any_chip_and_robots_records_stay(scripts: Page) -> None:
    rng = random.Random(7)
    chips = [chip_of(rng, chip) for chip in CHIPS.values() for _ in range(12)]
    texts = [
        [f"hazard: gas {k} é", f"note: {'x' * rng.randint(0, 300)}"][: rng.randint(1, 2)]
        for k in range(len(chips))
    ]
    cases = [
        {"payload": list(payload_of(chip)), "author": "Kim Å. Longest-Name", "texts": each}
        for chip, each in zip(chips, texts, strict=True)
    ]
    written = 0
    for chip, each, result in zip(chips, texts, scripts.evaluate(WRITE, cases), strict=True):
        if result == "full":
            continue
        written += 1
        before, after = read_tag(chip), read_tag(with_payload(chip, bytes(result)))
        told = b"".join(after.records)
        notes = unsealed_notes(told, TAG, KEY)
        assert [note.text for note in notes] == [
            text.encode()[:MAX_TEXT].decode("utf-8", "ignore") for text in reversed(each)
        ]
        assert {note.author for note in notes} == {"Kim Å. Longest-N"[:15]}
        assert after.link == LINK
        if before.records:
            says, said = open_memory(told, TAG, KEY), open_memory(b"".join(before.records), TAG, KEY)
            assert says.trusted
            assert says.memory == said.memory
            newer = seal(encode_memory(memory(rng).fit(after.room_bytes)), says.next_revision, TAG, KEY)
            again = with_payload(chip, bytes(result))
            write_tag(again, newer)  # a robot goes on as if nothing had been
            assert read_tag(again).records[0] == newer
    assert written > len(chips) / 2


def test_what_a_phone_cannot_read_is_never_written_over(scripts: Page) -> None:
    rng = random.Random(3)
    damaged = []
    for chip in CHIPS.values():
        tag = SimulatedTag.formatted(chip, LINK)
        write_tag(tag, seal(b"\x40", 0, TAG, KEY))
        payload = bytearray(payload_of(tag))
        payload[rng.randint(0, 12)] ^= 0xFF
        damaged.append(bytes(payload))
    damaged += [rng.randbytes(100), b"another program's data".ljust(212, b"\0")]
    cases = [{"payload": list(each), "author": "Kim", "texts": ["note: x"]} for each in damaged]
    assert scripts.evaluate(WRITE, cases) == ["unreadable"] * len(damaged)


def test_a_tag_is_opened_by_touch_and_a_word_is_left_in_its_chip(browser: Browser, drill: Any) -> None:
    host, tag_id, other = drill["host"], min(drill["tags"]), "Z9"
    link, chip = f"http://{host}/t/{tag_id}", SimulatedTag.formatted(CHIPS[7104], LINK)
    write_tag(chip, seal(encode_memory(TagMemory.empty()), 0, tag_id, KEY))
    context = browser.new_context(viewport={"width": 390, "height": 844}, locale="en-GB")
    context.add_init_script(NFC)
    page = context.new_page()
    page.goto(f"http://{host}/t")
    page.get_by_role("button", name="Touch tags with this phone").click()
    expect(page.get_by_text("Hold the phone's back to a tag")).to_be_visible()
    page.evaluate("touchChip('https://shop.example/offer', null)")
    expect(page.get_by_role("alert")).to_contain_text("no tag of Waymark")
    touch = "([link, payload]) => touchChip(link, payload)"
    page.evaluate(touch, [link, list(payload_of(chip))])
    expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)

    page.get_by_role("button", name="Leave word here").click()
    page.get_by_label("What is here").fill("gas, turn back")
    page.get_by_role("button", name="Hazard").click()
    page.get_by_role("button", name="Write it into the tag too").click()
    expect(page.get_by_text(f"Hold the phone still at tag {tag_id} now.")).to_be_visible()
    page.evaluate(touch, [f"http://{host}/t/{other}", list(payload_of(chip))])
    expect(page.get_by_role("alert")).to_contain_text(f"No mission here knows a tag {other}")  # it opened
    assert page.evaluate("globalThis.written") is None
    page.evaluate(touch, [f"https://usar.example/t/{tag_id}", list(payload_of(chip))])  # a namesake
    expect(page.get_by_role("alert").first).to_contain_text("for another server, usar.example")
    assert page.evaluate("globalThis.written") is None
    page.evaluate("globalThis.tears = true")
    page.evaluate(touch, [link, list(payload_of(chip))])
    expect(page.get_by_role("alert")).to_contain_text("Writing was cut short")
    page.evaluate("globalThis.tears = false")
    page.evaluate(touch, [link, list(payload_of(chip))])
    expect(page.get_by_text(f"It stands in tag {tag_id} now")).to_be_visible()
    address, payload = page.evaluate("globalThis.written")
    assert address == link
    after = read_tag(with_payload(chip, bytes(payload)))
    assert [note.text for note in unsealed_notes(b"".join(after.records), tag_id, KEY)] == [
        "hazard: gas, turn back"
    ]
    assert open_memory(b"".join(after.records), tag_id, KEY).trusted
    expect(page.get_by_text("gas, turn back").first).to_be_visible()

    def touched() -> int:
        found = httpx.get(f"http://{host}/api/v1/missions/drill/reports", timeout=30).json()["reports"]
        return sum(report["body"].get("tag_id") == tag_id for report in found if report["kind"] == "at")

    page.get_by_role("button", name="Leave word here").click()
    page.get_by_label("What is here").fill("not for the chip")
    page.get_by_role("button", name="Note", exact=False).first.click()
    page.get_by_role("button", name="Write it into the tag too").click()
    page.get_by_role("button", name="Do not write it").click()
    page.wait_for_function("navigator.onLine")
    before = touched()
    page.evaluate("globalThis.written = null")
    page.evaluate(touch, [link, payload])
    while touched() == before:  # one is at it again, wherever steps have led since
        page.wait_for_timeout(200)
    assert page.evaluate("globalThis.written") is None
    page.evaluate(touch, [f"https://usar.example/t/{tag_id}", payload])  # though its number is this one's
    expect(page.get_by_role("alert").first).to_contain_text("for another server, usar.example")
    context.close()


def test_what_another_phone_left_in_a_tag_is_carried_on_to_the_server(
    browser: Browser, drill: Any, scripts: Page
) -> None:
    """Of somebody whose name begins like that of the phone's owner, operator."""
    host, tag_id = drill["host"], drill["tags"][0]
    chip = SimulatedTag.formatted(CHIPS[2048], LINK)
    case = {
        "payload": list(payload_of(chip)),
        "author": "oper",
        "texts": ["hazard: wires é", "two doors", "exit: gate"],
    }
    (payload,) = scripts.evaluate(WRITE, [case])
    context = browser.new_context(viewport={"width": 390, "height": 844}, locale="en-GB")
    context.add_init_script(NFC)
    page = context.new_page()
    page.goto(f"http://{host}/t")
    page.get_by_role("button", name="Touch tags with this phone").click()
    for _ in range(2):
        page.evaluate("([link, payload]) => touchChip(link, payload)", [f"http://{host}/t/{tag_id}", payload])
        expect(page.get_by_role("heading", name=f"Tag {tag_id}")).to_be_visible(timeout=SOON_MS)
        expect(page.get_by_text("wires é").first).to_be_visible()
        page.wait_for_timeout(1500)
    found = httpx.get(f"http://{host}/api/v1/missions/drill/annotations", timeout=30).json()["annotations"]
    carried = {a["annotation_id"]: (a["kind"], a["text"]) for a in found if a["by"].startswith("oper (")}
    assert carried == {
        chip_note_id(tag_id, "oper", "hazard: wires é"): ("hazard", "wires é"),
        chip_note_id(tag_id, "oper", "two doors"): ("note", "two doors"),
        chip_note_id(tag_id, "oper", "exit: gate"): ("exit", "gate"),
    }
    context.close()


def test_where_the_browser_cannot_the_page_says_what_to_do_instead(browser: Browser, serve: Any) -> None:
    app = FastAPI()
    mount_web(app)
    context = browser.new_context(viewport={"width": 390, "height": 844})
    page = context.new_page()
    page.goto(f"http://{serve(app)}/t")
    expect(page.get_by_text("the phone offers its page. Where it does not, scan the label")).to_be_visible()
    expect(page.get_by_role("button", name="Touch tags")).to_have_count(0)
    context.close()
