"""Reports over links that fail in every way, from phone to phone and through tags: each once, none lost.

A real browser runs the outboxes of two phones against a real server. Requests are dropped on the way there
or the way back, answered with 503, sent twice; pages are reloaded, closed and opened twice at once in the
middle. A phone without signal hands its reports to the other by codes, some of which are missed or misread,
and sends them too once it is in reach. Words are left in tags' chips as well, some torn off halfway, and
brought home by phones and a robot.
"""

from __future__ import annotations

import base64
import io
import random
import re
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from PIL import Image

from server.benchmarks.browser import chromium, server_process
from server.benchmarks.outbox_field import MAPPED, PEOPLE, FieldOfTags, links
from server.benchmarks.outbox_phone import Link, Phone, scripts

_ACTIONS = {
    "report": 20, "send": 8, "reload": 5, "another": 2, "close": 2, "hand over": 6,
    "write into a tag": 5, "touch": 5, "robot reads a tag": 1,
}  # fmt: skip
_OF_A_MISSION = 100  # sequences: with thousands of notes every look at it takes a server longer
_OWN_PAGE = "/phone"
_CODES = re.compile(r"(WAYMARK1:[0-9a-f]+:\d+:\d+:)(.)(.*)")


@dataclass
class Tally:
    """What was made, id -> kind and text, what happened on the way, and what the server has in the end."""

    made: dict[str, tuple[str, str]] = field(default_factory=dict)
    faults: Counter[str] = field(default_factory=Counter)
    lost: list[str] = field(default_factory=list)
    doubled: list[str] = field(default_factory=list)
    victims: int = 0  # on the map
    carried: int = 0  # reports that another phone brought first
    from_tags: int = 0  # words that were brought home from a tag under an id of their own

    def __iadd__(self, other: Tally) -> Tally:
        """Add what was found in another mission."""
        self.made |= other.made
        self.faults += other.faults
        self.lost += other.lost
        self.doubled += other.doubled
        self.victims += other.victims
        self.carried += other.carried
        self.from_tags += other.from_tags
        return self


def run(contexts: Sequence[Any], field: FieldOfTags, sequences: int, seed: int, page: str) -> Tally:
    """Play sequences with two phones.

    Args:
        contexts: two of a browser (Playwright). They must block service workers, whose requests are not seen.
        field: the mission.
        page: where the outboxes run; any of the server's, the phone's own takes longer to load.

    Raises:
        TimeoutError: the links are sound, and for three minutes no report that waits has gone.
    """
    tally = Tally()
    script = "" if page == _OWN_PAGE else scripts(field.home)
    phones = []
    for context, cookie, name in zip(contexts, field.cookies, PEOPLE, strict=True):
        key, value = cookie.split("=", 1)
        context.add_cookies([{"name": key, "value": value, "url": field.home}])
        # how many requests there are must not change what is done
        link = Link(random.Random(f"{seed} {name}"), tally.faults, _picture)
        phones.append(Phone(context, field.home + page, name, link, script))
    game = _Game(phones, field, random.Random(seed), tally)
    for sequence in range(sequences):
        game.play(sequence)
    for phone in phones:
        phone.settle()
    _count(field, tally)
    return tally


class _Game:
    """Random sequences of what two people, their phones and a robot do."""

    def __init__(self, phones: list[Phone], field: FieldOfTags, rng: random.Random, tally: Tally) -> None:
        self._phones, self._field, self._rng, self._tally = phones, field, rng, tally
        self._count = 0

    def play(self, sequence: int) -> None:
        """Play one sequence; what waits at its end goes on waiting."""
        if sequence == 0 or self._rng.random() < 0.3:
            self._field.new_chips()
        for phone in self._phones:
            phone.link.share = self._rng.choice((0.2, 0.5, 0.8, 1.0))
            phone.link.has_signal = self._rng.random() < 0.65
        for step in range(self._rng.randint(4, 10)):
            (action,) = self._rng.choices(list(_ACTIONS), list(_ACTIONS.values()))
            one, other = self._rng.sample(self._phones, 2)
            self._act(action, one, other, f"{sequence}.{step}")
        for phone in self._phones:
            phone.keep_one()

    def _act(self, action: str, one: Phone, other: Phone, text: str) -> None:
        if action == "report":
            kind, body = self._report(text)
            self._tally.made[one.add(kind, body)] = kind, text
        elif action == "hand over":
            self._hand_over(one, other)
        elif action == "write into a tag":
            self._write(one, text)
        else:
            self._tally.faults[action] += 1
        if action == "send":
            one.send()
        elif action == "reload":
            one.reload()
        elif action == "another":
            one.open_another()
        elif action == "close":
            one.close()
        elif action == "touch":
            tag_id = self._tag()
            one.touch(self._field.link(tag_id), self._field.payload(tag_id))
        elif action == "robot reads a tag":
            self._field.bring_home()

    def _tag(self) -> str:
        """Return a tag with a chip; half of all are the one that the robot stands at."""
        return f"T{self._rng.choice((*range(MAPPED - 1), *[MAPPED - 1] * (MAPPED - 1)))}"

    def _hand_over(self, giver: Phone, taker: Phone) -> None:
        """Hand over by codes in any order, seen more than once; now and then something goes wrong."""
        rng, faults = self._rng, self._tally.faults
        codes = giver.codes()
        if not codes:
            return
        faults["handed over"] += 1
        seen = codes + rng.choices(codes, k=rng.randint(0, 3))
        rng.shuffle(seen)
        wrong = rng.random()
        is_taken = rng.random() < 0.75
        faults["what calls others was left"] += not is_taken
        if wrong < 0.15:
            faults["a code missed"] += 1
            taker.take([code for code in seen if code != codes[0]], is_taken)
            return
        if wrong < 0.3:
            faults["a code misread"] += 1
            misread = _CODES.sub(lambda m: m[1] + ("B" if m[2] == "A" else "A") + m[3], seen[-1])
            taker.take([*seen[:-1], misread], is_taken)
        elif wrong < 0.4:
            faults["reloaded halfway"] += 1
            taker.take(seen[: len(seen) // 2], is_taken)
            taker.reload()
        taker.take(seen, is_taken)

    def _write(self, phone: Phone, text: str) -> None:
        """Leave word at a tag, and the same in its chip."""
        rng, field, faults = self._rng, self._field, self._tally.faults
        tag_id = self._tag()
        phone.touch(field.link(tag_id), field.payload(tag_id))
        said = f"{text} {'and so on ' * rng.choice((0, 0, 2, 15))}".strip()  # more than a tag has room for
        kind, body, word = _word(rng, tag_id, said)
        if not phone.write_next(tag_id, word):
            faults["the phone does not know that tag"] += 1
            return
        self._tally.made[phone.add(kind, body)] = kind, text
        before = field.payload(tag_id)
        written, torn = phone.touch(field.link(tag_id), before, rng.random() < 0.25)
        if torn is not None:
            faults["torn off a tag"] += 1
            cut = 4 * rng.randint(0, len(before) // 4)
            field.write(tag_id, torn[:cut] + before[cut:])
            if rng.random() < 0.5:
                phone.write_next(tag_id, None)
            else:
                written, _ = phone.touch(field.link(tag_id), field.payload(tag_id))
        if written is not None:
            faults["written into a tag"] += 1
            field.write(tag_id, written)

    def _report(self, text: str) -> tuple[str, dict[str, Any]]:
        rng = self._rng
        (kind,) = rng.choices(("note", "victim", "photo", "mayday", "at", "heard"), (3, 3, 2, 1, 1, 1))
        if kind == "heard":
            return kind, {"since_unix_s": float(rng.randint(1, 9))}
        body: dict[str, Any] = {"tag_id": f"T{rng.randint(0, 2 * MAPPED - 1)}"}
        if kind != "at":
            body["text"] = text
        if kind == "note":
            body["note"] = rng.choice(("hazard", "note", "searched", "exit"))
        if kind == "victim":
            body |= {"live": rng.randint(0, 3), "dead": rng.randint(0, 1), "start": {"walks": True}}
        if kind == "photo":
            body["picture"] = base64.b64encode(_picture()).decode()
        return kind, body


def _word(rng: random.Random, tag_id: str, text: str) -> tuple[str, dict[str, Any], str]:
    """Return a report of a word left at a tag, and how it stands in the chip (report.js, victim_form.js)."""
    if rng.random() < 0.3:
        live, dead = rng.randint(0, 3), rng.randint(0, 1)
        body = {"tag_id": tag_id, "text": text, "live": live, "dead": dead, "start": {"walks": True}}
        return "victim", body, f"victim: L-{live} D-{dead} {text}"
    note = rng.choice(("hazard", "note", "searched", "exit"))
    return "note", {"tag_id": tag_id, "text": text, "note": note}, f"{note}: {text}"


def _picture() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (32, 24), (200, 60, 20)).save(file, "JPEG")
    return file.getvalue()


def _count(field: FieldOfTags, tally: Tally) -> None:
    """Compare with what the server has: the reports, and what stands on the map because of them."""
    photos = field.get("photos")["photos"]
    reports = [r for r in field.get("reports?limit=10000")["reports"] if r["kind"] != "at"]
    there = Counter([report["report_id"] for report in reports] + [photo["photo_id"] for photo in photos])
    notes = field.get("annotations")["annotations"]
    found = field.get("victims")["victims"]
    victims = [victim for victim in found if not victim["by"].startswith("tag ")]  # robots' marks are none
    said = [note["text"] for note in notes] + [victim["note"] for victim in victims]
    shown = Counter(_name(text) for text in said + [photo["text"] for photo in photos])
    for name, (kind, text) in tally.made.items():
        is_shown = kind in ("note", "victim", "photo")
        if (kind != "at" and not there[name]) or (is_shown and not shown[text]):  # of places the last counts
            tally.lost.append(name)
        if there[name] > 1 or shown[text] > 1:
            tally.doubled.append(name)
    known = {text for _, text in tally.made.values()}
    tally.doubled += [name for name in there if name not in tally.made and name not in field.copies]
    tally.doubled += [text for text in shown if text not in known]
    tally.victims = len(victims)
    tally.carried = sum("(carried by" in report["by"] for report in reports)
    tally.from_tags = len({report["report_id"] for report in reports} & field.copies)


def _name(text: str) -> str:
    """Return which report a text is of, by the number that each has in it."""
    found = re.search(r"\d+\.\d+", text)
    return text if found is None else found[0]


def measure(sequences: int, seed: int) -> dict[str, Any]:
    """Return how many reports were made, lost and doubled, and what they met on the way.

    Raises:
        CannotMeasureError: there is no browser here.
    """
    tally = Tally()
    with chromium() as browser:
        for begin in range(0, sequences, _OF_A_MISSION):
            tally += _in_a_mission(browser, min(_OF_A_MISSION, sequences - begin), seed * 100_000 + begin)
    found = {"sequences": sequences, "reports made": len(tally.made)}
    found |= Counter(kind for kind, _ in tally.made.values()) | {"victims on the map": tally.victims}
    found |= {"first brought by the other phone": tally.carried, "first read off a tag": tally.from_tags}
    return found | dict(tally.faults) | {"lost": len(tally.lost), "doubled": len(tally.doubled)}


def _in_a_mission(browser: Any, sequences: int, seed: int) -> Tally:
    with tempfile.TemporaryDirectory(prefix="waymark-bench-") as folder:
        secrets = links(Path(folder))
        with server_process(folder, login="on") as home:
            field = FieldOfTags(home, secrets, random.Random(seed + 1))
            contexts = [browser.new_context(service_workers="block") for _ in PEOPLE]
            tally = run(contexts, field, sequences, seed, page="/static/logo.svg")
            field.close()
            for context in contexts:
                context.close()
    return tally
