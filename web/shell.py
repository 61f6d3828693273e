"""The files that make the phone's page, found by its links and scripts, and the worker that keeps them."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass

from web.bundle import Sources, bundle
from web.combine import combine

_LINKS = re.compile(r'href="(/static/[^"]+)"')
_CLASSIC = re.compile(r'\.src = "([^"]+)"')  # scripts that are no modules, fetched when they are needed
PAGE, _WORKER = "/phone", "/static/phone/sw.js"


@dataclass(frozen=True, slots=True)
class Shell:
    """The phone's page, which holds what its first answer needs, and all that it loads: address -> bytes.

    ``hashes`` are those of the page's style and script, as a content security policy names them.
    """

    files: Mapping[str, bytes]
    hashes: Mapping[str, str]

    @property
    def page(self) -> bytes:
        """The page itself."""
        return self.files[PAGE]


def shell(sources: Sources) -> Shell:
    """Return the phone's shell.

    Raises:
        CombineError: its scripts cannot be combined.
    """
    made = bundle("phone", sources)
    beside = _LINKS.findall(made.page.decode())
    for script in (made.page, *made.later.values()):
        beside += _CLASSIC.findall(script.decode())
    files = {address: sources.read(address) for address in beside}
    for address in beside:
        if address.endswith(".webmanifest"):
            icons = [icon["src"] for icon in json.loads(files[address])["icons"]]
            files |= {icon: sources.read(icon) for icon in icons}
    return Shell({PAGE: made.page, **made.later, **files}, made.hashes)


def worker(sources: Sources, kept: Shell) -> bytes:
    """Return the service worker with the files it is to keep; it differs whenever one of them does."""
    hashes = {address: hashlib.sha256(data).hexdigest() for address, data in sorted(kept.files.items())}
    version = hashlib.sha256(json.dumps(hashes).encode()).hexdigest()[:16]
    head = f'self.VERSION = "{version}";\nself.FILES = {json.dumps(hashes, indent=0)};\n'
    script = combine([_WORKER], lambda address: sources.read(address).decode()).script(0)
    return (head + script).encode()
