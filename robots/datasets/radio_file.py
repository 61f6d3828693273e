"""A radio as a YAML file: settings of ``RadioConfig`` under ``radio``, as agents are told them."""

from __future__ import annotations

from pathlib import Path

import yaml

from robots.config import AgentConfig, ConfigError, RadioConfig
from robots.datasets.recording import RecordingError
from robots.overrides import override


def write_radio(path: Path, settings: dict[str, float]) -> None:
    """Write settings of a radio. Raises RecordingError where the file cannot be written."""
    try:
        path.write_text(yaml.safe_dump({"radio": settings}, sort_keys=False))
    except OSError as error:
        raise RecordingError(f"cannot write {path}: {error.strerror or error}") from error


def read_radio(path: Path) -> RadioConfig:
    """Return the radio of a file; what it leaves out is as usual.

    Raises:
        RecordingError: the file cannot be read, or holds something else.
    """
    try:
        raw = yaml.safe_load(path.read_text())
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror or error}") from error
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise RecordingError(f"{path} is no YAML file; write one with waymark fit-radio --out") from error
    if not isinstance(raw, dict) or set(raw) != {"radio"}:
        raise RecordingError(f"{path} has to hold settings of a radio under 'radio', and nothing else")
    try:
        return override(AgentConfig(), raw).radio
    except ConfigError as error:
        raise RecordingError(f"{path}: {error}") from error
