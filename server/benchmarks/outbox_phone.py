"""A phone with its page's scripts in a real browser, and a link to the server that fails in every way."""

from __future__ import annotations

import random
import re
import time
import urllib.request
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from server.benchmarks.browser import OWN_MODULE
from server.benchmarks.nfc_stub import NFC
from web.combine import combine

MISSION = "field"
_REPORTS = re.compile(r"/(reports/|photos\?)")
_API = re.compile(r"/api/v1/")
_SETTLES_S = 180.0  # a photo is waited for two minutes
# The outbox alone, begun where no page of the phone has begun it.
_OUTBOX = f"""{OWN_MODULE}("/static/phone/outbox.js").then(async (outbox) => {{
  globalThis.begun ??= document.getElementById("page") ? null
    : {OWN_MODULE}("/static/phone/reach.js").then(({{ askWho }}) => askWho()).then(() => outbox.openOutbox());
  await globalThis.begun;
  return outbox;
}})"""
_ADD = f"""async ([kind, {{ picture, ...body }}]) => {{
  const bytes = Uint8Array.from(atob(picture ?? ""), (letter) => letter.charCodeAt(0));
  if (picture) body.picture = new Blob([bytes], {{ type: "image/jpeg" }});
  return {_OUTBOX}.then(({{ add }}) => add(kind, '{MISSION}', body)).then(({{ id }}) => id);
}}"""
_SEND = f"() => {_OUTBOX}.then(({{ sendNow }}) => void sendNow())"
_SENT = f"() => {_OUTBOX}.then(({{ sendNow }}) => sendNow())"
_KEPT = f"""{OWN_MODULE}("/static/phone/kept.js")"""
_LEFT = f"""{_KEPT}.then(({{ all }}) => all("outbox"))
  .then((reports) => reports.map(({{ id, kind, refused }}) => `${{kind}} ${{id}} ${{refused}}`))"""
_CODES = f"""() => {_OUTBOX}.then(async ({{ waiting }}) => {{
  const {{ framesOf }} = await {OWN_MODULE}("/static/phone/handover.js");
  return waiting().length ? framesOf(waiting()) : [];
}})"""
_TAKE = f"""async ([codes, isTaken]) => {{
  await {_OUTBOX};
  const {{ answerOffer, takeCode }} = await {OWN_MODULE}("/static/phone/handover_view.js");
  for (const code of codes) await takeCode(code);
  await answerOffer(isTaken);
}}"""
_TOUCH = f"""async ([link, payload, tears]) => {{
  await {_OUTBOX};
  Object.assign(globalThis, {{ tears, written: null, torn: null }});
  await {OWN_MODULE}("/static/phone/nfc.js").then(({{ readTouched }}) => readTouched());
  await touchChip(link, payload);
  return {{ written: globalThis.written?.[1] ?? null, torn: globalThis.torn?.[1] ?? null }};
}}"""
_NEXT = f"""async ([tag, word]) => {{
  const {{ state }} = await {OWN_MODULE}("/static/phone/state.js");
  const {{ writeNext, writeNothing }} = await {OWN_MODULE}("/static/phone/nfc.js");
  if (word === null) writeNothing();
  else if (state.where?.tag_id === tag) await writeNext(word);
  return state.where?.tag_id === tag;
}}"""


_MODULES = ("outbox", "handover", "handover_view", "nfc", "memory_view", "reach", "state", "kept")


def scripts(home: str) -> str:
    """Return the phone's modules as one script, for pages that have none: fifty files take long to load."""

    def read(address: str) -> str:
        with urllib.request.urlopen(home + address, timeout=60) as answer:
            text: str = answer.read().decode()
            return text

    found = combine([f"/static/phone/{name}.js" for name in _MODULES], read)
    return f"if (location.protocol !== 'about:') (async () => {{\n{found.script(0)}\n}})();"


class Link:
    """The way to the server; ``share`` of the reports meet a fault, without signal nothing goes at all."""

    def __init__(self, rng: random.Random, faults: Counter[str], picture: Callable[[], bytes]) -> None:
        self.share = 0.0
        self.has_signal = True
        self._rng = rng
        self._faults = faults
        self._picture = picture

    def __call__(self, route: Any) -> None:
        """Let a request through, or not (a handler of Playwright's ``route``)."""
        is_report = _REPORTS.search(route.request.url) is not None
        if not self.has_signal:
            self._faults["without signal"] += is_report
            route.abort("internetdisconnected")
        elif not is_report or route.request.method == "GET" or self._rng.random() >= self.share:
            route.continue_()
        else:
            self._spoil(route)

    def _spoil(self, route: Any) -> None:
        fault = self._rng.choice(("lost on the way there", "lost on the way back", "busy", "sent twice"))
        self._faults[fault] += 1
        if fault == "lost on the way there":
            route.abort("connectionfailed")
        elif fault == "busy":
            route.fulfill(status=503, body="{}", headers={"Content-Type": "application/json"})
        elif fault == "lost on the way back":
            self._passed_on(route)
            route.abort("connectionreset")
        else:
            self._passed_on(route)
            self._answer(route)

    def _passed_on(self, route: Any) -> Any:
        """Send the request to the server; None where the server closed an idle connection just then."""
        # Playwright does not see what a Blob holds
        photo = self._picture() if "/photos?" in route.request.url else None
        try:
            return route.fetch(post_data=photo)
        except Exception as error:  # Playwright's own error is not imported where only the server runs
            if "ECONNRESET" not in str(error):
                raise
            return None

    def _answer(self, route: Any) -> None:
        response = self._passed_on(route)
        if response is None:
            route.abort("connectionreset")
        else:
            route.fulfill(response=response)


class Phone:
    """Somebody's phone.

    ``context``: of Playwright's, logged in; it must block service workers, whose requests are not seen.
    ``address``: the page in which the outbox runs; ``script``: to run in it before its own.
    """

    def __init__(self, context: Any, address: str, name: str, link: Link, script: str) -> None:
        self.name = name
        self.link = link
        self._context = context
        self._address = address
        context.add_init_script(NFC + script)
        context.route(_API, link)

    @property
    def page(self) -> Any:
        """The page in front, opened where none is."""
        if not self._context.pages:
            self.open_another()
        return self._context.pages[0]

    def open_another(self) -> None:
        """Open one more page; all send what waits."""
        self._context.new_page().goto(self._address)

    def reload(self) -> None:
        """Load the page again; what it had in its memory is gone."""
        self.page.goto(self._address)

    def close(self) -> None:
        """Close the page in the middle of whatever it does."""
        self.page.close()

    def keep_one(self) -> None:
        """Close all pages but one."""
        for extra in self._context.pages[1:]:
            extra.close()

    def add(self, kind: str, body: dict[str, Any]) -> str:
        """Make a report; its id."""
        name: str = self.page.evaluate(_ADD, [kind, body])
        return name

    def send(self) -> None:
        """Try to send everything, and wait for nothing."""
        self.page.evaluate(_SEND)

    def codes(self) -> list[str]:
        """Return the texts of the codes by which it would hand over what waits."""
        found: list[str] = self.page.evaluate(_CODES)
        return found

    def take(self, codes: Sequence[str], is_taken: bool) -> None:
        """Show it codes of another phone; ``is_taken``: its owner takes what they are asked about."""
        self.page.evaluate(_TAKE, [list(codes), is_taken])

    def touch(self, link: str, payload: bytes, tears: bool = False) -> tuple[bytes | None, bytes | None]:
        """Touch a tag; return what was written into its chip, and what was torn off halfway."""
        found = self.page.evaluate(_TOUCH, [link, list(payload), tears])
        written, torn = (None if found[name] is None else bytes(found[name]) for name in ("written", "torn"))
        return written, torn

    def write_next(self, tag_id: str, word: str | None) -> bool:
        """Write a word (None: nothing) at the next touch into the tag it is at; False: it is not there."""
        is_there: bool = self.page.evaluate(_NEXT, [tag_id, word])
        return is_there

    def settle(self) -> None:
        """Send until nothing waits any more, over a sound link.

        Raises:
            TimeoutError: for three minutes not one of those that wait has gone.
        """
        self.link.share, self.link.has_signal = 0.0, True
        since, before = time.monotonic(), None
        while left := self.page.evaluate(_LEFT):
            if len(left) != before:
                since, before = time.monotonic(), len(left)
            if time.monotonic() > since + _SETTLES_S:
                raise TimeoutError(f"the link is sound, and {', '.join(left)} still wait")
            self.page.evaluate(_SENT)
            self.page.wait_for_timeout(100)
