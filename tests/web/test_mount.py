"""The pages and their files: what is served, with which headers, and what without the npm packages."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from web.bundle import Sources, bundle
from web.lean import LEAN, lean_file
from web.mount import NODE_MODULES, STATIC, VENDOR_FILES, mount_web
from web.shell import shell

HAS_PACKAGES = all((NODE_MODULES / name).is_file() for name in VENDOR_FILES.values())


_LIBRARIES = {
    "preact/dist/preact.module.js": "const h = 1;\nexport { h, h as Component, h as render };",
    "htm/dist/htm.module.js": "export default { bind: String };",
}


@pytest.fixture
def packages(tmp_path: Path) -> Path:
    for name in VENDOR_FILES.values():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(_LIBRARIES.get(name, f"/* {name} */"))
    (tmp_path / "secret.txt").write_text("not for anybody")
    return tmp_path


@pytest.fixture
def client(packages: Path, serve: Callable[[FastAPI], str]) -> Iterator[httpx.Client]:
    app = FastAPI()
    mount_web(app, node_modules=packages)
    with httpx.Client(base_url=f"http://{serve(app)}", timeout=90) as client:
        yield client


@pytest.mark.parametrize("address", ["/", "/console"])
def test_the_console_is_served_under_a_strict_policy(client: httpx.Client, address: str) -> None:
    response = client.get(address)
    assert response.status_code == 200
    assert "<title>Waymark</title>" in response.text
    policy = response.headers["content-security-policy"].split("; ")
    assert {"default-src 'none'", "frame-ancestors 'self'"} <= set(policy)
    (script,) = re.findall(r'<script type="module"[^>]*>(.*?)</script>', response.text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'self' 'sha256-{digest}'" in policy
    assert response.headers["x-content-type-options"] == "nosniff"
    assert response.headers["referrer-policy"] == "no-referrer"


@pytest.mark.parametrize(
    "address", ["/", "/console", "/favicon.ico", "/static/console/main.js", "/vendor/leaflet/leaflet.js"]
)
def test_head_is_answered_like_get_without_a_body(client: httpx.Client, address: str) -> None:
    response = client.head(address)
    assert response.status_code == 200
    assert response.content == b""
    assert int(response.headers["content-length"]) > 0


@pytest.mark.parametrize(
    "address", ["/console", "/static/console/main.js", "/vendor/preact/preact.module.js"]
)
def test_a_file_the_browser_has_already_is_not_sent_again(client: httpx.Client, address: str) -> None:
    first = client.get(address)
    assert first.headers["cache-control"] == "no-cache"
    again = client.get(address, headers={"If-None-Match": first.headers["etag"]})
    assert again.status_code == 304
    assert again.content == b""


def test_modules_have_a_type_that_browsers_run(client: httpx.Client) -> None:
    for address in ("/static/console/main.js", "/vendor/htm/htm.module.js"):
        assert "javascript" in client.get(address).headers["content-type"]
    assert client.get("/favicon.ico").headers["content-type"].startswith("image/svg+xml")


@pytest.mark.parametrize(
    "address", ["secret.txt", "../package.json", "%2e%2e/package.json", "leaflet/dist/leaflet.js", ""]
)
def test_only_the_listed_vendor_files_are_served(client: httpx.Client, address: str) -> None:
    response = client.get(f"/vendor/{address}")
    assert response.status_code == 404


def test_without_packages_the_page_says_what_to_do(tmp_path: Path, serve: Callable[[FastAPI], str]) -> None:
    app = FastAPI()
    mount_web(app, node_modules=tmp_path / "node_modules")
    with httpx.Client(base_url=f"http://{serve(app)}") as client:
        response = client.get("/")
        assert response.status_code == 503
        assert "make setup" in response.text
        assert client.get("/vendor/leaflet/leaflet.js").status_code == 404


@pytest.mark.skipif(not HAS_PACKAGES, reason="the npm packages are not installed: run make setup")
def test_every_module_the_pages_import_exists() -> None:
    for module in STATIC.rglob("*.js"):
        for address in re.findall(r'(?:from|import) "([^"]+)"', module.read_text()):
            if address.startswith("/vendor/"):
                target = NODE_MODULES / VENDOR_FILES[address.removeprefix("/vendor/")]
            else:
                target = module.parent / address
            assert target.is_file(), f"{module.name} imports {address}"


def test_every_file_the_console_links_is_served(client: httpx.Client) -> None:
    links = re.findall(r'(?:href|src)="(/[^"]+)"', client.get("/console").text)
    assert len(links) >= 3
    assert {link: client.get(link).status_code for link in links} == dict.fromkeys(links, 200)


def test_no_page_writes_text_as_markup() -> None:
    """Robots, tags and people write what the console shows: it must never be parsed as HTML."""
    for module in STATIC.rglob("*.js"):
        text = module.read_text()
        for name in (
            "innerHTML",
            "outerHTML",
            "insertAdjacentHTML",
            "document.write",
            "dangerouslySetInnerHTML",
        ):
            assert name not in text, f"{module.name} uses {name}"
        assert not re.search(r"\beval\(|new Function\(", text), module.name


def test_the_lock_file_pins_without_naming_a_host() -> None:
    lock = (NODE_MODULES.parent / "package-lock.json").read_text()
    assert '"integrity"' in lock
    assert "resolved" not in lock
    assert "://" not in re.sub(r'"url": "[^"]*"', "", lock)


@pytest.mark.skipif(not HAS_PACKAGES, reason="the npm packages are not installed: run make setup")
def test_the_console_stays_small() -> None:
    """All own scripts and styles of the console come in its page, with two libraries, in less than 100 kB."""
    vendor = {address: NODE_MODULES / name for address, name in VENDOR_FILES.items()}
    page = bundle("console", Sources(STATIC, vendor)).page
    modules = {path.name for path in (STATIC / "console").glob("*.js")} - {"types.js"}
    assert set(re.findall(r"^// /static/console/(\S+)$", page.decode(), re.MULTILINE)) == modules
    styles = {path.name for path in (STATIC / "console" / "css").iterdir()}
    source = (STATIC / "console" / "index.html").read_text()
    assert set(re.findall(r'href="/static/console/css/(\S+)"', source)) == styles
    assert 40_000 < len(gzip.compress(page, 9)) < 100_000


def test_only_comments_are_left_out() -> None:
    """A comment's line begins outside of every text in backticks, and all other lines stay where they are."""
    for path in sorted(p for p in STATIC.rglob("*") if p.suffix in LEAN):
        before, after = path.read_text().split("\n"), lean_file(path).decode().split("\n")
        assert len(before) == len(after), path
        ticks, in_comment = 0, False
        for old, new in zip(before, after, strict=True):
            if old != new:
                begins = old.lstrip().startswith(("//", "/*"))
                assert new == "", (path, old)
                assert begins or in_comment, (path, old)
                assert ticks % 2 == 0, (path, old)
                in_comment = (in_comment or old.lstrip().startswith("/*")) and "*/" not in old
            elif path.suffix == ".js":
                ticks += old.replace("\\`", "").count("`")


def test_files_go_compressed_over_the_wire(client: httpx.Client) -> None:
    plain = client.get("/static/console/main.js", headers={"Accept-Encoding": "identity"})
    packed = client.get("/static/console/main.js")
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.content == plain.content
    assert "content-encoding" not in plain.headers
    again = client.get("/static/console/main.js", headers={"If-None-Match": packed.headers["etag"]})
    assert again.status_code == 304


@pytest.mark.skipif(not HAS_PACKAGES, reason="the npm packages are not installed: run make setup")
def test_the_phones_worker_keeps_every_file_as_it_is_served(serve: Callable[[FastAPI], str]) -> None:
    app = FastAPI()
    mount_web(app)
    with httpx.Client(base_url=f"http://{serve(app)}") as client:
        script = client.get("/sw.js").text
        files = json.loads(re.search(r"self\.FILES = (\{.*?\});", script, re.DOTALL)[1])
        for name in (
            "/phone",
            "/static/phone/manifest.webmanifest",
            "/static/phone/icon-512.png",
            "/vendor/jsqr/jsQR.js",
        ):
            assert name in files
        for address, expected in files.items():
            assert hashlib.sha256(client.get(address).content).hexdigest() == expected, address
        page = client.get("/t/A-017")
        later = page
        for step in (1, 2):
            (name,) = re.findall(rf"/app/[0-9a-f]{{16}}/phone\.{step}\.js", later.text)
            assert name in files
            later = client.get(name)
        assert not re.search(r'stylesheet|<script[^>]* src="', page.text)  # the answer needs no other file
        assert client.get("/phone", headers={"If-None-Match": page.headers["etag"]}).status_code == 304
        assert "immutable" in later.headers["cache-control"]
        assert later.headers["content-encoding"] == "gzip"
        other = client.get(re.sub(r"[0-9a-f]{16}", "0" * 16, name))
        assert (other.status_code, other.text) == (
            404,
            "This file is of another version of the page: reload the page.",
        )
        policy = client.get("/sw.js").headers["content-security-policy"]
        assert "worker-src 'self'" in policy
        assert "manifest-src 'self'" in policy


@pytest.mark.skipif(not HAS_PACKAGES, reason="the npm packages are not installed: run make setup")
def test_what_a_phone_loads_for_its_first_answer_is_small() -> None:
    kept = shell(Sources(STATIC, {address: NODE_MODULES / name for address, name in VENDOR_FILES.items()}))
    (name,) = (name for name in kept.files if name.endswith("/phone.1.js"))
    first, then = (len(gzip.compress(part, 9)) for part in (kept.page, kept.files[name]))
    assert 3_000 < first < 10_000
    assert 20_000 < first + then < 80_000
