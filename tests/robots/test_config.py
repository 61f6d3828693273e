"""Settings change where they are told to, and say by name what is wrong with a change."""

from dataclasses import fields, is_dataclass
from math import inf, nan

import numpy as np
import pytest

from robots.agent import RobotAgent
from robots.config import AgentConfig, AntennaConfig, ConfigError, PlanningConfig
from robots.overrides import override


def as_changes(config) -> dict:
    values = {item.name: getattr(config, item.name) for item in fields(config)}
    return {name: as_changes(value) if is_dataclass(value) else value for name, value in values.items()}


def test_nested_changes_change_nothing_else():
    before = AgentConfig()
    after = override(before, {"body": {"radius_m": 0.3}, "seed": 5, "graph": {"method": "linear"}})
    assert after.body.radius_m == 0.3
    assert after.seed == 5
    assert after.graph.method == "linear"
    assert after.body.track_width_m == before.body.track_width_m
    assert after.mapping == before.mapping
    assert before == AgentConfig()


def test_the_defaults_pass_their_own_checks():
    assert override(AgentConfig(), as_changes(AgentConfig())) == AgentConfig()
    assert override(AgentConfig(), {}) == AgentConfig()


def test_numbers_take_the_type_of_their_field():
    after = override(AgentConfig(), {"body": {"radius_m": 1}, "deployment": {"magazine": 12.0}})
    assert isinstance(after.body.radius_m, float)
    assert isinstance(after.deployment.magazine, int)


def test_an_optional_number_can_be_set_and_taken_back():
    disc = override(AgentConfig(), {"antenna": {"radius_m": 0.2}})
    assert disc.antenna.radius_m == 0.2
    assert override(disc, {"antenna": {"radius_m": None}}) == AgentConfig()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"colour": "red"}, r"config\.colour is no setting; known are body, antenna"),
        ({"body": {"radius": 0.3}}, r"config\.body\.radius is no setting; known are radius_m"),
        ({"body": 0.3}, r"config\.body has to be an object"),
        ({"body": {"radius_m": "0.3"}}, r"config\.body\.radius_m has to be a finite number"),
        ({"body": {"radius_m": True}}, r"config\.body\.radius_m has to be a finite number"),
        ({"body": {"radius_m": None}}, r"config\.body\.radius_m has to be a finite number"),
        ({"body": {"radius_m": nan}}, r"config\.body\.radius_m has to be a finite number"),
        ({"body": {"radius_m": inf}}, r"config\.body\.radius_m has to be a finite number"),
        ({"seed": 10**400}, r"config\.seed has to be a finite number"),
        ({"seed": 1.5}, r"config\.seed has to be a whole number"),
        ({"seed": -1}, r"config\.seed has to be 0 or more"),
        ({"antenna": {"radius_m": "wide"}}, r"config\.antenna\.radius_m has to be a finite number"),
        ({"antenna": {"radius_m": 0.0}}, r"config\.antenna\.radius_m has to be more than 0"),
        ({"mapping": {"resolution_m": 0.0}}, r"config\.mapping\.resolution_m has to be more than 0"),
        ({"mapping": {"limit_logodds": 200}}, r"config\.mapping\.limit_logodds has to be 127 or less"),
        ({"imu": {"yaw_sd_rad": -0.1}}, r"config\.imu\.yaw_sd_rad has to be 0 or more"),
        ({"planning": {"explore": 3}}, r"config\.planning\.explore has to be text"),
        ({"graph": {"method": "fast"}}, r"config\.graph\.method has to be one of gauss-newton, linear"),
        ({"poses": "Truth"}, r"config\.poses has to be one of slam, truth"),
    ],
)
def test_a_wrong_change_is_named(changes, message):
    with pytest.raises(ConfigError, match=message):
        override(AgentConfig(), changes)


def test_the_antenna_may_sit_behind_the_base():
    assert override(AgentConfig(), {"antenna": {"ahead_m": -0.1}}).antenna.ahead_m == -0.1


def test_an_unknown_strategy_is_named_when_the_agent_is_made():
    config = override(AgentConfig(), {"planning": {"explore": "zigzag"}})
    with pytest.raises(ConfigError, match=r"planning\.explore: no strategy is called 'zigzag'"):
        RobotAgent("r1", config)


def test_footprint_variances_against_sampling():
    rng = np.random.default_rng(1)
    plate = AntennaConfig(along_m=0.3, across_m=0.2)
    points = rng.uniform([-0.15, -0.1], [0.15, 0.1], (100_000, 2))
    np.testing.assert_allclose(plate.variances, points.var(axis=0), rtol=0.02)
    disc = AntennaConfig(along_m=9.0, radius_m=0.4)
    points = rng.uniform(-0.4, 0.4, (200_000, 2))
    points = points[np.hypot(*points.T) < 0.4]
    np.testing.assert_allclose(disc.variances, points.var(axis=0), rtol=0.02)


@pytest.mark.parametrize("side", [-1.0, 1e9, float("nan")])
def test_a_small_map_is_small(side):
    with pytest.raises(ConfigError, match="local_map_m"):
        PlanningConfig(local_map_m=side)
