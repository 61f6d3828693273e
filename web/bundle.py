"""A page with its own styles in one file and its own scripts in two, made by the server from the sources."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from web.combine import combine
from web.lean import lean_file

_STYLE = re.compile(rb'[ \t]*<link rel="stylesheet" href="(/static/[^"]+)">\n')
_SCRIPT = re.compile(rb'[ \t]*<script type="module"[^>]* src="(/static/[^"]+)"></script>\n')


@dataclass(frozen=True, slots=True)
class Bundle:
    """A page and what it loads: address -> bytes. Addresses change with what is behind them."""

    page: bytes
    early: Mapping[str, bytes]
    later: Mapping[str, bytes]

    @property
    def files(self) -> Mapping[str, bytes]:
        """All files but the page."""
        return {**self.early, **self.later}


class Sources:
    """Files of the pages by their addresses: our own under /static, libraries under /vendor."""

    def __init__(self, static: Path, vendor: Mapping[str, Path]) -> None:
        self.static = static
        self._vendor = vendor

    def read(self, address: str) -> bytes:
        """Return a file, our own without its comments.

        Raises:
            OSError: there is no such file.
        """
        if address.startswith("/static/"):
            return lean_file(self.static / address.removeprefix("/static/"))
        name = address.removeprefix("/vendor/")
        if name not in self._vendor:
            raise FileNotFoundError(address)
        return self._vendor[name].read_bytes()

    def state(self) -> tuple[tuple[str, int], ...]:
        """Return something that differs once any of our own files has changed."""
        return tuple((str(path), path.stat().st_mtime_ns) for path in sorted(self.static.rglob("*.*")))


def bundle(folder: str, sources: Sources) -> Bundle:
    """Return the page of a folder under /static, which loads its styles and scripts combined.

    Raises:
        CombineError: its scripts cannot be combined.
    """
    page = (sources.static / folder / "index.html").read_bytes()
    style = b"".join(sources.read(address.decode()) for address in _STYLE.findall(page))
    names = {"style": f"{folder}.css", "first": f"{folder}.js", "later": f"{folder}.later.js"}
    entries = [address.decode() for address in _SCRIPT.findall(page)]
    scripts = combine(entries, lambda address: sources.read(address).decode(), f"./{names['later']}")
    first, later = scripts.first.encode(), scripts.later.encode()
    version = hashlib.sha256(b"\0".join((style, first, later))).hexdigest()[:16]
    at = {part: f"/app/{version}/{name}" for part, name in names.items()}
    page = _in_one(_STYLE, page, f'  <link rel="stylesheet" href="{at["style"]}">\n')
    # nothing is painted before the script has run: the first paint is then its first answer
    page = _in_one(
        _SCRIPT, page, f'  <script type="module" blocking="render" src="{at["first"]}"></script>\n'
    )
    return Bundle(page, {at["style"]: style, at["first"]: first}, {at["later"]: later} if later else {})


def _in_one(these: re.Pattern[bytes], page: bytes, one: str) -> bytes:
    """Put one line in the place of the first of many, and leave the others out."""
    found = iter([one.encode()])
    return these.sub(lambda _: next(found, b""), page)
