"""The files that make the phone's page, found by its links and imports, and the worker that keeps them."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path

_LINKS = re.compile(r'(?:href|src)="(/[^"]+)"')
_IMPORTS = re.compile(r'^(?:import|export)\b[^;]*?\bfrom "([^"]+)";|^import "([^"]+)";', re.MULTILINE)
_LAZY = re.compile(r'\b(?:import\(|\.src = )"([^"]+)"')
PAGE, WORKER = "/phone", "phone/sw.js"


def shell_files(static: Path, vendor: Mapping[str, Path]) -> dict[str, Path]:
    """Return address -> file of all that the phone's page loads; ``vendor``: what is served under /vendor."""
    page = static / "phone" / "index.html"
    files = {PAGE: page}
    waiting = [address for address in _LINKS.findall(page.read_text()) if address.startswith("/static/")]
    while waiting:
        address = waiting.pop()
        path = vendor.get(address.removeprefix("/vendor/"), static / address.removeprefix("/static/"))
        if address in files or not path.is_file():
            continue
        files[address] = path
        if path.suffix == ".js":
            waiting += [_resolved(address, to) for to in _imports(path.read_text())]
        if path.suffix == ".webmanifest":
            waiting += [icon["src"] for icon in json.loads(path.read_text())["icons"]]
    return files


def worker(static: Path, vendor: Mapping[str, Path]) -> bytes:
    """Return the service worker with the files it is to keep; it differs whenever one of them does."""
    files = shell_files(static, vendor)
    hashes = {address: _hash(path.read_bytes()) for address, path in sorted(files.items())}
    version = _hash(json.dumps(hashes).encode())[:16]
    head = f'self.VERSION = "{version}";\nself.FILES = {json.dumps(hashes, indent=0)};\n'
    return head.encode() + (static / WORKER).read_bytes()


def _imports(text: str) -> list[str]:
    return [one or other for one, other in _IMPORTS.findall(text)] + _LAZY.findall(text)


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
