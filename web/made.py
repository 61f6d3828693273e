"""What the server makes of the pages' sources: once, kept compressed, and anew when a source has changed."""

from __future__ import annotations

import gzip
import hashlib
import json
import mimetypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fastapi import Request
from fastapi.responses import Response

from web.bundle import Bundle, Sources, bundle
from web.shell import PAGE, Shell, shell, worker

CONSOLE = "/console"
_TOLD = b'<script type="application/json" id="told">'
_NEVER_CHANGES = "public, max-age=31536000, immutable"  # its address names its content


@dataclass(frozen=True, slots=True)
class Ready:
    """An answer that is ready to be sent."""

    body: bytes
    packed: bytes
    kind: str
    etag: str
    headers: Mapping[str, str]

    def response(self, request: Request) -> Response:
        """Return it as this browser takes it, or 304 when the browser has it already."""
        headers = {**self.headers, "ETag": self.etag, "Vary": "Accept-Encoding"}
        if request.headers.get("if-none-match") == self.etag:
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", ""):
            return Response(
                self.packed, headers={**headers, "Content-Encoding": "gzip"}, media_type=self.kind
            )
        return Response(self.body, headers=headers, media_type=self.kind)

    def telling(self, told: Mapping[str, Any]) -> Ready:
        """Return the page with what is told to this reader alone: as data, which no text in it can end."""
        text = json.dumps(told, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
        body = self.body.replace(_TOLD, _TOLD + text.encode(), 1)
        headers = {**self.headers, "Cache-Control": "private, no-store"}
        return _ready(body, self.kind, headers, level=4)


class Made:
    """The console, the phone's page and what it loads, by address."""

    def __init__(self, sources: Sources, headers: Mapping[str, str]) -> None:
        self._sources = sources
        self._headers = headers
        self._state: object = None
        self._ready: dict[str, Mapping[str, Ready]] = {}

    def find(self, address: str) -> Ready | None:
        """Return what is at an address, None where nothing is.

        Raises:
            CombineError: scripts cannot be combined.
            OSError: a file that a page names is not there.
        """
        state = self._sources.state()
        if state != self._state:
            self._ready = {}
            self._state = state
        page = CONSOLE if address == CONSOLE else PAGE
        if page not in self._ready:
            self._ready[page] = self._console() if page == CONSOLE else self._phone()
        return self._ready[page].get(address)

    def _console(self) -> dict[str, Ready]:
        return {CONSOLE: self._page(bundle("console", self._sources))}

    def _phone(self) -> dict[str, Ready]:
        kept = shell(self._sources)
        ready = {
            address: self._made(address, data)
            for address, data in kept.files.items()
            if address.startswith("/app/")
        }
        ready[PAGE] = self._page(kept)
        ready["/sw.js"] = _ready(worker(self._sources, kept), "text/javascript", self._headers)
        return ready

    def _page(self, made: Bundle | Shell) -> Ready:
        policy = self._headers.get("Content-Security-Policy", "")
        for kind, hashed in made.hashes.items():
            policy = policy.replace(f"{kind} 'self'", f"{kind} 'self' {hashed}")
        return _ready(made.page, "text/html", {**self._headers, "Content-Security-Policy": policy})

    def _made(self, address: str, data: bytes) -> Ready:
        kind = mimetypes.guess_type(address)[0] or "text/javascript"
        return _ready(data, kind, {**self._headers, "Cache-Control": _NEVER_CHANGES})


def _ready(data: bytes, kind: str, headers: Mapping[str, str], level: int = 9) -> Ready:
    etag = f'"{hashlib.sha256(data).hexdigest()[:20]}"'
    return Ready(data, gzip.compress(data, level), kind, etag, headers)
