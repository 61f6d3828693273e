"""A page with its own styles and first script within it, made by the server from the sources."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from web.combine import CombineError, combine
from web.lean import lean_file

_STYLE = re.compile(rb'[ \t]*<link rel="stylesheet" href="(/static/[^"]+)">\n')
_SCRIPT = re.compile(rb'[ \t]*<script type="module"[^>]* src="(/static/[^"]+)"></script>\n')
_ENDS = re.compile(
    rb"</(?:script|style)|<!--", re.IGNORECASE
)  # what a script or style within a page may not hold


@dataclass(frozen=True, slots=True)
class Bundle:
    """A page with what it needs first within it; ``later``: address -> bytes, changes with what is behind it.

    ``hashes`` are those of its style and scripts, as a content security policy names them.
    """

    page: bytes
    hashes: Mapping[str, str]
    later: Mapping[str, bytes]


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
    """Return the page of a folder under /static with its styles and its scripts' first step within it.

    Raises:
        CombineError: its scripts cannot be combined, or not be put into a page.
    """
    page = (sources.static / folder / "index.html").read_bytes()
    style = b"".join(sources.read(address.decode()) for address in _STYLE.findall(page))
    entries = [address.decode() for address in _SCRIPT.findall(page)]
    scripts = combine(entries, lambda address: sources.read(address).decode())
    later: dict[str, bytes] = {}
    address = ""
    for number in range(len(scripts.steps) - 1, 0, -1):
        script = scripts.script(number, address).encode()
        address = f"/app/{hashlib.sha256(script).hexdigest()[:16]}/{folder}.{number}.js"
        later[address] = script
    first = scripts.script(0, address).encode()
    for part in (style, first):
        if found := _ENDS.search(part):
            raise CombineError(
                f"A style or script of /{folder} holds {found.group().decode()}: write it in two parts."
            )
    page = _in_one(_STYLE, page, b"  <style>%s</style>\n" % style)
    # nothing is painted before the script has run: the first paint is then its first answer
    page = _in_one(_SCRIPT, page, b'  <script type="module" blocking="render">%s</script>\n' % first)
    return Bundle(page, {"style-src": _hash(style), "script-src": _hash(first)}, later)


def _hash(part: bytes) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(part).digest()).decode()}'"


def _in_one(these: re.Pattern[bytes], page: bytes, one: bytes) -> bytes:
    """Put one in the place of the first of many, and leave the others out."""
    found = iter([one])
    return these.sub(lambda _: next(found, b""), page)
