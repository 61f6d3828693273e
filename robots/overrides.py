"""Changing settings by name, as in ``{"body": {"radius_m": 0.3}}``, with what was typed checked."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from math import isfinite
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from robots.config import ConfigError

C = TypeVar("C")

# others are 0 or more
_SIGNED = frozenset({"ahead_m", "front_ahead_m", "power_at_1m_dbm", "rear_ahead_m", "start"})
_POSITIVE = frozenset(
    {
        "along_m",
        "anchor_travel_m",
        "anchor_turn_rad",
        "across_m",
        "alpha",
        "base_reach_m",
        "bearing_sd_rad",
        "cell_m",
        "gate_sd",
        "key_scan_m",
        "key_scan_rad",
        "local_scans",
        "max_range_m",
        "max_speed_mps",
        "max_turn_radps",
        "obstacle_sd_m",
        "offset_sd_m",
        "outlier_reach_m",
        "outlier_share",
        "particles",
        "path_loss_exponent",
        "place_m",
        "place_sd_m",
        "point_sd_m",
        "radius_m",
        "range_sd_m",
        "reach_m",
        "readings",
        "resolution_m",
        "safe_m",
        "scale_sd",
        "spacing_m",
        "tag_kernel_sd",
        "tau_m",
        "track_width_m",
        "window_m",
        "window_rad",
    }
)
_LONGEST = 100  # of a list of numbers
_INT8 = frozenset({"hit_logodds", "miss_logodds", "limit_logodds"})  # as they leave the process


def override(config: C, changes: dict[str, Any], where: str = "config") -> C:
    """Return the config with nested changes applied, as in ``{"body": {"radius_m": 0.3}}``.

    Raises:
        ConfigError: a name is unknown, or a value is of the wrong type or out of range; the message names it.
    """
    hints = get_type_hints(type(config))
    # dataclasses have no common class to bind C to, so fields and replace cannot see that it is one
    known = {item.name: getattr(config, item.name) for item in fields(config)}  # type: ignore[arg-type]
    new: dict[str, Any] = {}
    for name, value in changes.items():
        if name not in known:
            raise ConfigError(f"{where}.{name} is no setting; known are {', '.join(known)}")
        new[name] = _checked(known[name], hints[name], value, f"{where}.{name}")
    return replace(config, **new)  # type: ignore[type-var]


def _checked(old: Any, hint: Any, value: Any, where: str) -> Any:
    if is_dataclass(old) and not isinstance(old, type):
        if not isinstance(value, dict):
            raise ConfigError(f"{where} has to be an object")
        return override(old, value, where)
    if isinstance(old, str):
        if not isinstance(value, str):
            raise ConfigError(f"{where} has to be text")
        if get_origin(hint) is Literal and value not in get_args(hint):
            raise ConfigError(f"{where} has to be one of {', '.join(get_args(hint))}")
        return value
    if value is None and type(None) in get_args(hint):
        return value
    if isinstance(old, tuple):
        if not isinstance(value, list | tuple) or len(value) > _LONGEST:
            raise ConfigError(f"{where} has to be a list of at most {_LONGEST} numbers")
        return tuple(_checked(0.0, float, each, where) for each in value)
    if isinstance(old, bool):
        if not isinstance(value, bool):
            raise ConfigError(f"{where} has to be true or false")
        return value
    if isinstance(value, bool) or not isinstance(value, int | float) or not _is_finite(value):
        raise ConfigError(f"{where} has to be a finite number")
    _check_range(value, where)
    if isinstance(old, int):
        if value != int(value):
            raise ConfigError(f"{where} has to be a whole number")
        return int(value)
    return float(value)


def _is_finite(value: float) -> bool:
    try:
        return isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def _check_range(value: float, where: str) -> None:
    name = where.rpartition(".")[2]
    if name in _POSITIVE and value <= 0:
        raise ConfigError(f"{where} has to be more than 0")
    if name not in _SIGNED and value < 0:
        raise ConfigError(f"{where} has to be 0 or more")
    if name in _INT8 and value > 127:
        raise ConfigError(f"{where} has to be 127 or less")
