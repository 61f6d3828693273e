"""Many modules as a few scripts: they do in a browser what the modules did; errors have names."""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from collections.abc import Mapping
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.responses import Response
from hypothesis import given, settings
from hypothesis import strategies as st
from playwright.sync_api import Browser

from web.bundle import Sources, bundle
from web.combine import Combined, CombineError, combine
from web.made import Made
from web.mount import NODE_MODULES, SECURITY_HEADERS, STATIC, VENDOR_FILES, mount_web

TALLY = """
const run = [];
export const ran = (name) => run.push(name);
export { run as order };
"""
FORMS = {
    "/m/tally.js": TALLY,
    "/m/shapes.js": """import { ran } from "./tally.js";
ran("shapes");
export class Square { constructor(side) { this.side = side; } }
export function area({ side }) { return side * side; }
export async function later(value) { return value; }
export function* three() { yield 1; yield 2; yield 3; }
export const unit = /** @type {Square} */ (new Square(1));
var n = "mine";
export { n as name, n };
""",
    "/lib/small.js": 'var n="theirs",t=()=>n;export default function(x){return n+x}\n'
    "//# sourceMappingURL=small.js.map\n",
    "/m/aside.js": """import { ran } from "./tally.js";
import { unit } from "./shapes.js";
ran("aside");
export const seen = unit;
export const last = () => import("./last.js").then(({ word }) => word);
""",
    "/m/main.js": """import { order, ran } from "./tally.js";
import join from "/lib/small.js";
import { area as measured, later, name, Square,
  three, unit } from "./shapes.js";
import * as all from "./shapes.js";
import "./effect.js";
ran("main");
const value = await later(7);
export const found = {
  joined: join("!"), name, area: measured(new Square(3)), value, three: [...three()],
  whole: Object.keys(all).sort(), same: all.unit === unit,
};
const { seen, last } = await import("./aside.js");
export const again = [seen === unit, (await import("./shapes.js")).unit === unit, await last(), order];
""",
    "/m/last.js": 'import { ran } from "./tally.js";\nran("last");\nexport const word = "last";\n',
    "/m/effect.js": 'import { ran } from "./tally.js";\nran("effect");\n',
}
FOUND = {
    "joined": "theirs!",
    "name": "mine",
    "area": 9,
    "value": 7,
    "three": [1, 2, 3],
    "whole": ["Square", "area", "later", "n", "name", "three", "unit"],
    "same": True,
}


def combined(files: Mapping[str, str], *entries: str) -> Combined:
    def read(address: str) -> str:
        if address not in files:
            raise FileNotFoundError(address)
        return files[address]

    return combine(entries, read)


def page_with(browser: Browser, serve: Any, files: Mapping[str, str]) -> Any:
    app = FastAPI()

    @app.get("/{path:path}")
    def file(path: str) -> Response:
        return Response(files.get(f"/{path}", ""), media_type="text/javascript")

    page = browser.new_page()
    page.goto(f"http://{serve(app)}/empty")
    return page


def test_combined_modules_do_in_a_browser_what_modules_do(browser: Browser, serve: Any) -> None:
    made = combined(FORMS, "/m/main.js")
    assert [step.modules for step in made.steps[1:]] == [("/m/aside.js",), ("/m/last.js",)]
    scripts = {f"/{k}.js": made.script(k, f"./{k + 1}.js") for k in range(3)}
    page = page_with(browser, serve, FORMS | scripts)
    plain = page.evaluate("import('/m/main.js').then(({ found, again }) => [found, again])")
    one = page.evaluate("import('/0.js').then(() => Object.values(modules$['/m/main.js']))")
    page.close()
    assert plain == one
    assert one == [FOUND, [True, True, "last", ["shapes", "effect", "main", "aside", "last"]]]


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"/a.js": 'import { b } from "./b.js";'}, "/a.js imports /b.js, which is not there"),
        ({"/a.js": 'import("./b.js");'}, "A page or an import\\(\\) names /b.js, which is not there"),
        ({"/a.js": 'import { h } from "preact";'}, "/a.js imports /preact, which is not there"),
        (
            {"/a.js": 'import { x } from "./b.js";', "/b.js": "export const b = 1;"},
            "imports x from /b.js, which does",
        ),
        (
            {"/a.js": 'import x from "./b.js";', "/b.js": "export const x = 1;"},
            "imports default from /b.js, which does",
        ),
        (
            {"/a.js": 'import "./b.js";', "/b.js": 'import "./c.js";', "/c.js": 'import "./b.js";'},
            "/b.js imports /c.js imports /b.js: a circle",
        ),
        ({"/a.js": "export let x = 1;"}, "`export let x = 1;`, which cannot be combined"),
        ({"/a.js": "export const { x } = y;"}, "cannot be combined"),
        ({"/a.js": 'export * from "./b.js";'}, "cannot be combined"),
        ({"/a.js": 'export { x } from "./b.js";'}, "cannot be combined"),
        ({"/a.js": "export default class A {}"}, "cannot be combined"),
    ],
)
def test_what_cannot_be_combined_is_named(files: Mapping[str, str], message: str) -> None:
    with pytest.raises(CombineError, match=message):
        combined(files, "/a.js")


@settings(deadline=None)
@given(st.lists(st.sets(st.integers(0, 30)), min_size=1, max_size=20), st.randoms())
def test_each_module_is_there_once_behind_all_that_it_imports(above: list[set[int]], draw: Any) -> None:
    """For any graph without circles, some of whose imports are for later."""
    needs = {k: {j for j in asked if j < k} for k, asked in enumerate(above)}
    isfirst = {k: {j for j in asked if draw.random() < 0.7} for k, asked in needs.items()}
    files = {}
    for k, asked in needs.items():
        now = "".join(f'import {{ n as n{j} }} from "./{j}.js";\n' for j in sorted(isfirst[k]))
        then = "".join(f'export const f{j} = () => import("./{j}.js");\n' for j in sorted(asked - isfirst[k]))
        files[f"/{k}.js"] = f"{now}{then}export const n = {k};\n"
    made = combined(files, f"/{len(above) - 1}.js")
    there: list[int] = []
    asked = {len(above) - 1}
    for step in made.steps:
        here = [int(name[1:-3]) for name in step.modules]
        assert _reached(asked, isfirst) - set(there) == set(here)
        for k in here:
            assert isfirst[k] <= set(there)
            assert f'modules["/{k}.js"] = {{ ' in step.body
            there.append(k)
        asked = {j for k in here for j in needs[k]} - set(there)
    assert asked == set()
    assert len(set(there)) == len(there)


def _reached(asked: set[int], isfirst: Mapping[int, set[int]]) -> set[int]:
    reached: set[int] = set()
    while asked:
        k = asked.pop()
        reached.add(k)
        asked |= isfirst[k] - reached
    return reached


def test_the_phones_modules_export_in_one_what_they_export_alone(browser: Browser, serve: Any) -> None:
    app = FastAPI()
    mount_web(app)
    page = browser.new_page()
    page.goto(f"http://{serve(app)}/phone")
    found = page.evaluate(
        """async () => {
          const modules = globalThis.modules$;
          while (!modules["/static/phone/rest.js"]) await new Promise((resolve) => setTimeout(resolve, 20));
          const differ = {};
          for (const [address, one] of Object.entries(modules)) {
            if (address === "/static/phone/first.js") continue; // it would begin a second time
            const alone = await import(address);
            const kindOf = (it) => Object(it) === it ? `${typeof it} ${it.length}` : it;
            const kinds = (all) => Object.keys(all).sort().map((name) => [name, kindOf(all[name])]).join();
            if (kinds(alone) !== kinds(one)) differ[address] = [kinds(alone), kinds(one)];
          }
          return [Object.keys(modules).length, differ];
        }"""
    )
    page.close()
    assert found[0] > 40
    assert found[1] == {}


def test_only_types_are_taken_from_within_lines() -> None:
    """A comment within a line begins outside of every text."""
    for path in STATIC.rglob("*.js"):
        for line in path.read_text().splitlines():
            before, mark, comment = line.partition("/**")
            is_in_code = all(before.count(tick) % 2 == 0 for tick in "\"'`")
            assert not mark or is_in_code or comment.startswith(" @type {"), (path, line)


def test_a_source_that_changes_makes_another_file(tmp_path: Any) -> None:
    folder = tmp_path / "static"
    for path in STATIC.rglob("*"):
        if path.is_file():
            copy = folder / path.relative_to(STATIC)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    made = Made(
        Sources(folder, {name: NODE_MODULES / file for name, file in VENDOR_FILES.items()}), SECURITY_HEADERS
    )
    before = made.find("/phone")
    address = folder / "phone" / "address.js"
    address.write_text("const KEPT = 1;\n" + address.read_text())
    after = made.find("/phone")
    assert before is not None
    assert after is not None
    assert before.body != after.body
    assert b"const KEPT = 1" in after.body
    policy = after.headers["Content-Security-Policy"]
    (script,) = re.findall(rb'<script type="module"[^>]*>(.*?)</script>', after.body, re.DOTALL)
    assert f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'" in policy
    assert policy != before.headers["Content-Security-Policy"]
    rest = folder / "phone" / "rest.js"
    rest.write_text(rest.read_text() + "\nconst kept = 1;\n")
    (one,) = re.findall(r"/app/[\w/.]+", after.body.decode())
    last = made.find("/phone")
    assert last is not None
    (other,) = re.findall(r"/app/[\w/.]+", last.body.decode())
    assert one != other
    assert made.find(other) is not None
    assert made.find(one) is None


def test_a_script_that_would_end_its_element_is_refused(tmp_path: Any) -> None:
    page = '<script type="module" src="/static/odd/a.js"></script>\n'
    (tmp_path / "odd").mkdir()
    (tmp_path / "odd" / "index.html").write_text(page)
    for text in ("</Script>", "<!--"):
        (tmp_path / "odd" / "a.js").write_text(f'export const a = "{text}";')
        with pytest.raises(CombineError, match="write it in two parts"):
            bundle("odd", Sources(tmp_path, {}))


def test_what_is_told_to_one_reader_is_data_whatever_it_says(browser: Browser, serve: Any) -> None:
    vendor = {name: NODE_MODULES / file for name, file in VENDOR_FILES.items()}
    made = Made(Sources(STATIC, vendor), SECURITY_HEADERS).find("/phone")
    assert made is not None
    hostile = "</script><img src=x onerror=alert(1)><!-- <script> \u2028 \" \\ ' &lt;"
    told = made.telling({"language": "en", "where": {"tag_id": "A", "text": hostile, "victims": []}})
    assert told.headers["Cache-Control"] == "private, no-store"
    assert gzip.decompress(told.packed) == told.body
    app = FastAPI()
    app.get("/t/B")(lambda: Response(told.body, headers=dict(told.headers), media_type=told.kind))
    page = browser.new_page()
    page.goto(f"http://{serve(app)}/t/B")
    assert page.evaluate("JSON.parse(document.getElementById('told').textContent).where.text") == hostile
    assert page.locator("img").count() == 0
    page.close()
