"""The files that make the phone's page, found by its links and imports, and the worker that keeps them."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from web.lean import lean_file

_LINKS = re.compile(r'(?:href|src)="(/[^"]+)"')
_IMPORTS = re.compile(r'^(?:import|export)\b[^;]*?\bfrom "([^"]+)";|^import "([^"]+)";', re.MULTILINE)
_LAZY = re.compile(r'\b(?:import\(|\.src = )"([^"]+)"')
_HEAD_ENDS = b"</head>"
PAGE, _WORKER = "/phone", "phone/sw.js"


@dataclass(frozen=True, slots=True)
class Shell:
    """The phone's page and all that it loads: address -> bytes; ``early`` what its first answer needs."""

    files: Mapping[str, bytes]
    early: tuple[str, ...]

    @property
    def page(self) -> bytes:
        """The page, which names its modules so that a browser asks for all of them at once."""
        return self.files[PAGE]

    @property
    def etag(self) -> str:
        """A name for the page that changes with it."""
        return f'"{_hash(self.page)[:20]}"'


def shell(static: Path, vendor: Mapping[str, Path]) -> Shell:
    """Return the phone's shell; ``vendor``: what is served under /vendor."""
    page = (static / "phone" / "index.html").read_bytes()
    files: dict[str, bytes] = {}
    early: list[str] = []
    waiting = [(address, True) for address in _LINKS.findall(page.decode()) if address.startswith("/static/")]
    while waiting:
        address, is_early = waiting.pop()
        path = vendor.get(address.removeprefix("/vendor/"), static / address.removeprefix("/static/"))
        if not path.is_file() or (address in files and (address in early or not is_early)):
            continue
        files[address] = path.read_bytes() if address.startswith("/vendor/") else lean_file(path)
        if path.suffix in (".js", ".mjs"):
            if is_early:
                early.append(address)
            waiting += _imports(address, files[address].decode(), is_early)
        if path.suffix == ".webmanifest":
            waiting += [(icon["src"], False) for icon in json.loads(files[address])["icons"]]
    links = "".join(f'  <link rel="modulepreload" href="{address}">\n' for address in sorted(early))
    files[PAGE] = page.replace(_HEAD_ENDS, links.encode() + _HEAD_ENDS)
    styles = [address for address in files if address.endswith(".css")]
    return Shell(files, (PAGE, *sorted(early), *styles))


def worker(static: Path, kept: Shell) -> bytes:
    """Return the service worker with the files it is to keep; it differs whenever one of them does."""
    hashes = {address: _hash(data) for address, data in sorted(kept.files.items())}
    version = _hash(json.dumps(hashes).encode())[:16]
    head = f'self.VERSION = "{version}";\nself.FILES = {json.dumps(hashes, indent=0)};\n'
    return head.encode() + (static / _WORKER).read_bytes()


def _imports(of: str, text: str, is_early: bool) -> list[tuple[str, bool]]:
    first = [(one or other, is_early) for one, other in _IMPORTS.findall(text)]
    later = [(address, False) for address in _LAZY.findall(text)]
    return [(_resolved(of, to), early) for to, early in first + later]


def _resolved(of: str, to: str) -> str:
    """Return the address that an import in a module means."""
    if to.startswith("/"):
        return to
    parts = of.split("/")[:-1]
    for part in to.split("/"):
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
