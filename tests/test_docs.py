"""Documentation that would otherwise grow old: commands, settings and routes have to be in it."""

from __future__ import annotations

import re
from pathlib import Path

import typer

from server.app import create_app
from server.cli.main import build
from server.settings import Settings

ROOT = Path(__file__).parent.parent


def test_every_command_is_in_the_readme() -> None:
    readme = (ROOT / "README.md").read_text()
    commands = set(typer.main.get_command(build()).commands)
    elsewhere = {"demo", "warm"}  # `make run` is the demonstration, `make setup` warms up
    assert {name for name in commands - elsewhere if f"waymark {name}" not in readme} == set()


def test_links_between_documents_lead_somewhere() -> None:
    for document in ROOT.glob("*.md"):
        for target in re.findall(r"\]\(([^)#]+)\)", document.read_text()):
            if "://" not in target:
                assert (ROOT / target).exists(), f"{document.name} points to {target}"


def test_the_map_of_the_code_names_every_folder() -> None:
    architecture = (ROOT / "ARCHITECTURE.md").read_text()
    folders = [
        path.name
        for package in ("robots", "server", "web")
        for path in (ROOT / package).iterdir()
        if (path / "__init__.py").exists()
    ]
    assert [name for name in folders if name not in architecture] == []


def test_make_targets_named_in_the_readme_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    for name in set(re.findall(r"make (\w+)", (ROOT / "README.md").read_text())):
        assert re.search(rf"^{name}:", makefile, re.MULTILINE), f"make {name}"


def test_every_setting_explains_itself(tmp_path: Path) -> None:
    for name, field in Settings.model_fields.items():
        assert field.description, name


def test_every_route_explains_itself(tmp_path: Path) -> None:
    schema = create_app(Settings(data_dir=tmp_path)).openapi()
    for path, operations in schema["paths"].items():
        for method, operation in operations.items():
            assert operation.get("summary"), f"{method} {path}"
            assert operation.get("description"), f"{method} {path}"
