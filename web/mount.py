"""Hang the pages and their files into the application: console, /static, /vendor, icon and 3D view."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request
from fastapi.responses import HTMLResponse, PlainTextResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.datastructures import Headers
from starlette.middleware.gzip import GZipMiddleware
from starlette.responses import FileResponse
from starlette.staticfiles import NotModifiedResponse
from starlette.types import Scope

from web.bundle import Sources
from web.lean import LEAN, lean_file
from web.made import CONSOLE, Made
from web.proxy import Gate, ScenePorts, mount_proxy

_HERE = Path(__file__).parent
STATIC = _HERE / "static"
NODE_MODULES = _HERE / "node_modules"

# What the pages load from npm packages: address under /vendor -> file under node_modules. No other is served.
VENDOR_FILES: Mapping[str, str] = {
    "leaflet/leaflet.js": "leaflet/dist/leaflet.js",
    "leaflet/leaflet.css": "leaflet/dist/leaflet.css",
    "preact/preact.module.js": "preact/dist/preact.module.js",
    "htm/htm.module.js": "htm/dist/htm.module.js",
    "jsqr/jsQR.js": "jsqr/dist/jsQR.js",
    "lean-qr/index.mjs": "lean-qr/index.mjs",
}
_OF_PHONES_ALONE = ("jsqr/", "lean-qr/")  # without them the console is whole

CONTENT_SECURITY_POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "frame-src 'self'",
        "manifest-src 'self'",
        "worker-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'self'",
    )
)
SECURITY_HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    # Own files change with every release and have no hash in their names: the browser asks each time, and an
    # ETag makes the answer a short 304.
    "Cache-Control": "no-cache",
}

_MISSING_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Waymark: set-up is not complete</title>
<h1>Set-up is not complete</h1>
<p>The browser libraries are not installed, so this page cannot be shown.</p>
<p>Run <code>make setup</code> in the project's folder, then reload. Nothing else is affected: the mission
goes on and the API answers.</p>
</html>
"""

_NOT_HERE = "This file is of another version of the page: reload the page."


class _Files(StaticFiles):
    """A folder of static files, each answer with the security and cache headers."""

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        """Return the file, or 304 when the browser has it already."""
        return _file_response(full_path, stat_result, Headers(scope=scope), status_code)


class _OwnFiles(_Files):
    """Our own static files, scripts and styles without their comments."""

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        """Return the file, or 304 when the browser has it already."""
        path = Path(full_path)
        if path.suffix not in LEAN:
            return super().file_response(full_path, stat_result, scope, status_code)
        body = lean_file(path)
        headers = {**SECURITY_HEADERS, "ETag": f'"{hashlib.sha256(body).hexdigest()[:20]}"'}
        if Headers(scope=scope).get("if-none-match") == headers["ETag"]:
            return Response(status_code=304, headers=headers)
        kind = "text/javascript" if path.suffix == ".js" else "text/css"
        return Response(body, status_code, headers, kind)


class _VendorFiles(_Files):
    """The few files of ``VENDOR_FILES``, found in the folder of installed npm packages."""

    async def check_config(self) -> None:
        """Accept that the folder is not there: then every file is missing, and the pages say so."""

    def lookup_path(self, path: str) -> tuple[str, os.stat_result | None]:
        """Return the installed file behind an address under /vendor; no stat when there is none."""
        name = VENDOR_FILES.get(path.replace(os.sep, "/"))
        return super().lookup_path(name) if name else ("", None)


def mount_web(
    app: FastAPI,
    viser: tuple[ScenePorts, Gate] | None = None,
    node_modules: Path = NODE_MODULES,
    told_at: Callable[[Request, str], Awaitable[Mapping[str, Any] | None]] | None = None,
) -> None:
    """Add the pages, /static, /vendor, /favicon.ico and, if given, /viser to the app.

    ``viser``: what tells the loopback port of a mission's viser server, and who may see it;
    ``node_modules`` is npm's folder; ``told_at`` returns what to write into the phone's page at a tag, None
    where there is nothing to say, or nothing for whoever asks.
    """

    async def console(request: Request) -> Response:
        return find(request, CONSOLE)

    async def door(request: Request) -> Response:
        return _page(request, STATIC / "door" / "index.html")

    async def people(request: Request) -> Response:
        return _page(request, STATIC / "people" / "index.html")

    async def missions(request: Request) -> Response:
        return _page(request, STATIC / "missions" / "index.html")

    vendor_files = {address: node_modules / name for address, name in VENDOR_FILES.items()}

    made = Made(Sources(STATIC, vendor_files), SECURITY_HEADERS)

    def find(request: Request, address: str, told: Mapping[str, Any] | None = None) -> Response:
        needless = _OF_PHONES_ALONE if address == CONSOLE else ()
        if any(not p.is_file() for name, p in vendor_files.items() if not name.startswith(needless)):
            return HTMLResponse(_MISSING_PAGE, status_code=503, headers=dict(SECURITY_HEADERS))
        ready = made.find(address)
        if ready and told is not None:
            ready = ready.telling(told)
        return ready.response(request) if ready else PlainTextResponse(_NOT_HERE, status_code=404)

    async def phone(request: Request) -> Response:
        tag_id = request.path_params.get("tag_id")
        told = None if tag_id is None or told_at is None else await told_at(request, tag_id)
        return find(request, "/phone", told)

    async def file(request: Request) -> Response:
        return find(request, request.url.path)

    async def icon(request: Request) -> Response:
        return _page(request, STATIC / "logo.svg")

    for address in ("/", "/console"):
        app.add_api_route(address, console, methods=["GET", "HEAD"], include_in_schema=False)
    for address in ("/login", "/join"):
        app.add_api_route(address, door, methods=["GET", "HEAD"], include_in_schema=False)
    for address in ("/phone", "/t", "/t/{tag_id}"):
        app.add_api_route(address, phone, methods=["GET", "HEAD"], include_in_schema=False)
    for address in ("/sw.js", "/app/{version}/{name}"):
        app.add_api_route(address, file, methods=["GET", "HEAD"], include_in_schema=False)
    app.add_api_route("/missions", missions, methods=["GET", "HEAD"], include_in_schema=False)
    app.add_api_route("/people", people, methods=["GET", "HEAD"], include_in_schema=False)
    app.add_api_route("/favicon.ico", icon, methods=["GET", "HEAD"], include_in_schema=False)
    app.mount("/static", GZipMiddleware(_OwnFiles(directory=STATIC)), name="static")
    vendor = _VendorFiles(directory=node_modules, check_dir=False)
    app.mount("/vendor", GZipMiddleware(vendor), name="vendor")
    if viser is not None:
        mount_proxy(app, *viser)


def _page(request: Request, path: Path) -> Response:
    return _file_response(path, path.stat(), request.headers, 200)


def _file_response(
    path: str | os.PathLike[str], stat_result: os.stat_result, request_headers: Headers, status_code: int
) -> Response:
    response = FileResponse(
        path, status_code=status_code, stat_result=stat_result, headers=dict(SECURITY_HEADERS)
    )
    if request_headers.get("if-none-match") == response.headers["etag"]:
        return NotModifiedResponse(response.headers)
    return response
