"""The image, the continuous integration and the Makefile speak of the same things."""

import re
import subprocess
from pathlib import Path

import pytest
import yaml

from server.cli.main import run

ROOT = Path(__file__).parents[2]
MAKEFILE = (ROOT / "Makefile").read_text()
TARGETS = set(re.findall(r"^([a-z]+):", MAKEFILE, flags=re.MULTILINE))


def test_every_target_has_its_sentence():
    shown = subprocess.run(
        ["make", "-C", str(ROOT), "help"], capture_output=True, text=True, check=True
    ).stdout
    described = set(re.findall(r"^make ([a-z]+) +\S", shown, flags=re.MULTILINE))
    assert described == TARGETS
    assert {"setup", "run", "test", "lint", "bench", "lock", "clean"} <= TARGETS


@pytest.mark.parametrize("name", ["docker/Dockerfile", ".ci/run"])
def test_only_targets_that_exist_are_called(name):
    lines = [line for line in (ROOT / name).read_text().splitlines() if not line.lstrip().startswith("#")]
    called = set(re.findall(r"(?:^|RUN|then)\s*make ([a-z]+)", "\n".join(lines), flags=re.MULTILINE))
    assert called
    assert called <= TARGETS


def test_continuous_integration_ends_in_make_test():
    script = ROOT / ".ci" / "run"
    assert script.read_text().rstrip().endswith("\nmake test")
    assert script.stat().st_mode & 0o111
    subprocess.run(["bash", "-n", str(script)], check=True)


def test_the_image_runs_a_command_that_exists_as_an_ordinary_user(capsys):
    dockerfile = (ROOT / "docker" / "Dockerfile").read_text()
    assert re.search(r"^USER waymark$", dockerfile, flags=re.MULTILINE)
    assert "/api/v1/health" in dockerfile
    options = re.findall(r'"(--[a-z]+)"', dockerfile)
    assert '["serve"' in dockerfile
    assert run(["serve", "--help"]) == 0
    shown = capsys.readouterr().out
    assert all(option in shown for option in options)


def test_compose_builds_that_image_and_keeps_its_data():
    compose = yaml.safe_load((ROOT / "docker" / "compose.yaml").read_text())
    service = compose["services"]["waymark"]
    build = service["build"]
    assert (ROOT / "docker" / build["context"]).resolve() == ROOT
    assert (ROOT / build["dockerfile"]).exists()
    volume, folder = service["volumes"][0].split(":")
    assert volume in compose["volumes"]
    assert f'"--data", "{folder}"' in (ROOT / build["dockerfile"]).read_text()


def test_locks_pin_by_hash_and_name_no_registry():
    for name in ("requirements.lock", "requirements-node.lock"):
        lock = (ROOT / name).read_text()
        assert "://" not in lock, name
        pins = re.findall(r"^[a-z0-9].*==.*$", lock, flags=re.MULTILINE | re.IGNORECASE)
        assert pins
        assert all(pin.endswith("\\") for pin in pins), name  # hashes follow
