"""Who may import whom, and what may lie in the repository: read from the sources, not from intentions."""

import ast
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("robots", "db", "web", "server")
BESIDE_THE_AGENT = ("robots.sim", "robots.datasets", "robots.experiments")
GLUE = ("robots.outputs", "robots.evaluation", "robots.client", "robots.warmup")
TYPES = (
    "robots.types",
    "robots.orders",
    "robots.se2",
    "robots.graph_report",
    "robots.codec",
    "robots.config",
    "robots.team.types",
)
MATHEMATICS = {"numpy", "scipy", "numba", "qdldl", "bitstruct"}
SOURCES = {".py", ".js", ".css", ".html", ".mako"}
LONG_FOR_A_REASON: set[str] = set()  # files past 300 lines, each with its reason


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(tree: ast.AST, module: str, is_package: bool) -> Iterator[str]:
    """Every name a file imports, whole: functions' own imports and those for type checkers included."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".")
                up = parts[: len(parts) - node.level + is_package]
                base = ".".join([*up, base] if base else up)
            yield from (f"{base}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "import_module":
            yield from (
                a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str)
            )


@lru_cache(maxsize=1)
def imports() -> dict[str, frozenset[str]]:
    """What each module of the packages imports."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            if "node_modules" not in path.parts:
                module = module_of(path)
                tree = ast.parse(path.read_text(), str(path))
                found[module] = frozenset(imports_of(tree, module, path.name == "__init__.py"))
    return found


def within(name: str, *modules: str) -> bool:
    return any(name == module or name.startswith(f"{module}.") for module in modules)


def breaches(importers: tuple[str, ...], *forbidden: str, but: tuple[str, ...] = ()) -> list[str]:
    return [
        f"{module} imports {name}"
        for module, names in imports().items()
        for name in sorted(names)
        if within(module, *importers) and within(name, *forbidden) and not within(name, *but)
    ]


def test_there_is_something_to_read():
    assert len(imports()) > 80
    assert within("numpy", *MATHEMATICS)
    assert "robots.estimation.kalman.fuse" in imports()["robots.estimation.tracking"]


def test_relative_and_late_imports_are_seen_too():
    text = (
        "from . import a\nfrom ..x import b\n"
        "def f():\n    import viser\nimportlib.import_module('db.store')\n"
    )
    names = set(imports_of(ast.parse(text), "web.viser.scene", False))
    assert names == {"web.viser.a", "web.x.b", "viser", "db.store"}
    assert set(imports_of(ast.parse("from . import a"), "web.viser", True)) == {"web.viser.a"}


def test_robots_know_nobody():
    assert breaches(("robots",), "server", "db", "web") == []


def test_db_and_web_know_types_of_robots_and_never_each_other():
    assert breaches(("db",), "web", "server") == []
    assert breaches(("web",), "db", "server") == []
    assert breaches(("db", "web"), "robots", but=TYPES) == []


def test_the_algorithms_know_neither_simulator_nor_recordings():
    algorithms = tuple(
        module
        for module in imports()
        if within(module, "robots") and not within(module, *BESIDE_THE_AGENT, *GLUE)
    )
    assert len(algorithms) > 30
    exactly = {module: imports()[module] for module in algorithms}
    found = [
        f"{module} imports {name}"
        for module, names in exactly.items()
        for name in sorted(names)
        if within(name, *BESIDE_THE_AGENT)
    ]
    assert found == []


def test_the_algorithms_use_mathematics_and_the_standard_library_only():
    allowed = MATHEMATICS | set(sys.stdlib_module_names) | {"robots"}
    found = [
        f"{module} imports {name}"
        for module, names in imports().items()
        for name in sorted(names)
        if within(module, "robots")
        and not within(module, *BESIDE_THE_AGENT, *GLUE)
        and name.partition(".")[0] not in allowed
    ]
    assert found == []


def test_only_the_3d_layers_import_viser():
    found = [
        module
        for module, names in imports().items()
        if any(within(name, "viser") for name in names) and not within(module, "web.viser")
    ]
    assert found == []


def test_an_agent_can_be_loaded_without_the_rest():
    """As its process does; also what is only imported by way of something else is seen here."""
    program = (
        "import sys, robots.agent, robots.team\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules}))\n"
        "print(*sorted(name for name in sys.modules if name.startswith('robots.')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=60, check=True
    )
    tops, own = (set(line.split()) for line in done.stdout.splitlines())
    assert not tops & {"server", "db", "web", "fastapi", "sqlalchemy", "viser", "typer", "PIL"}
    assert not {name for name in own if within(name, *BESIDE_THE_AGENT)}
    assert "robots.estimation.graph.solve" in own


# What lies in the repository


@lru_cache(maxsize=1)
def files() -> tuple[Path, ...]:
    """Files that are committed, or would be."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout: which files belong to the project is not known")
    done = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return tuple(path for name in done.stdout.split("\0") if name and (path := ROOT / name).is_file())


def text_of(path: Path) -> str:
    return path.read_bytes().decode("utf-8", errors="ignore")


def test_tests_and_docker_are_no_packages():
    assert [path for folder in ("tests", "docker") for path in (ROOT / folder).rglob("__init__.py")] == []


def test_every_folder_of_the_packages_is_one():
    """A folder that only happens to be importable would be left out of the wheel."""
    found = {
        path.parent
        for path in files()
        if path.suffix == ".py" and path.relative_to(ROOT).parts[0] in PACKAGES
    }
    assert [folder for folder in sorted(found) if not (folder / "__init__.py").exists()] == []


def test_no_source_file_is_too_long():
    lengths = {
        str(path.relative_to(ROOT)): text_of(path).count("\n") for path in files() if path.suffix in SOURCES
    }
    assert {name: lines for name, lines in lengths.items() if lines > 500} == {}
    questioned = {name for name, lines in lengths.items() if lines > 300 and not name.startswith("tests/")}
    print("over 300 lines:", {name: lines for name, lines in lengths.items() if lines > 300})
    assert questioned <= LONG_FOR_A_REASON
    packages = sorted(lines for name, lines in lengths.items() if name.split("/")[0] in PACKAGES)
    assert packages[len(packages) // 2] <= 130


@pytest.mark.parametrize(
    "words",
    ["/" + "work/", "/" + "root/", "registry.npmjs" + ".org", "files.pythonhosted" + ".org"],
    ids=["a path of one machine", "a home of one machine", "npm's host", "a package index's host"],
)
def test_nothing_of_the_machine_it_was_made_on_is_in_it(words):
    assert [str(path.relative_to(ROOT)) for path in files() if words in text_of(path)] == []
