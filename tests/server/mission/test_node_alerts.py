"""Alerts about nodes: raised once, ended once, whatever the readings do in between."""

from math import radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from db.records import NodeRecord
from server.mission.node_alerts import RULES, Watch, with_usual_pressure

HOT, TILTED, PRESSURE = RULES


def node(temperature_c=20.0, pressure_hpa=1013.0, tilt_rad=0.0, usual=1013.0):
    return NodeRecord("N1", temperature_c, pressure_hpa, tilt_rad, usual, 0.0, "r1")


def states(rule, readings):
    watch = Watch(rule)
    found = []
    for reading in readings:
        watch.take(reading)
        found.append(watch.active)
    return found


@pytest.mark.parametrize(
    ("rule", "calm", "between", "bad"),
    [
        (HOT, node(20.0), node(55.0), node(80.0)),
        (TILTED, node(), node(tilt_rad=radians(28.0)), node(tilt_rad=radians(80.0))),
        (PRESSURE, node(), node(pressure_hpa=1011.0), node(pressure_hpa=1009.0)),
    ],
)
def test_an_alert_holds_until_it_is_calm_for_a_while(rule, calm, between, bad):
    assert states(rule, [calm, between, between]) == [False] * 3
    assert states(rule, [bad, calm, bad, bad]) == [False, False, False, True]
    assert states(rule, [bad, bad, *[between] * 20]) == [False, *[True] * 21]
    assert states(rule, [bad, bad, *[calm] * 10]) == [False, *[True] * 10, False]


@given(st.lists(st.floats(-50.0, 500.0), max_size=60))
def test_readings_that_swing_between_the_thresholds_change_nothing(temperatures):
    changes = 0
    watch = Watch(HOT)
    for t in temperatures:
        changes += watch.take(node(t))
    assert changes <= 1 + len(temperatures) // 12  # two to raise it, ten to end it
    assert watch.active == (changes % 2 == 1)


def test_a_cool_twin_does_not_silence_a_hot_node():
    found = states(HOT, [node(90.0), node(90.0), *[node(90.0), node(18.0)] * 20])
    assert all(found[1:])


def test_what_is_not_measured_says_nothing():
    assert states(HOT, [node(temperature_c=None)] * 3) == [False] * 3
    assert states(PRESSURE, [node(usual=None)] * 3) == [False] * 3


def test_the_usual_pressure_follows_slowly():
    usual = None
    for _ in range(10):
        usual = with_usual_pressure(node(pressure_hpa=1013.0), usual).usual_pressure_hpa
    assert usual == 1013.0
    usual = with_usual_pressure(node(pressure_hpa=1005.0), usual).usual_pressure_hpa
    assert usual > 1012.9
    for _ in range(2000):
        usual = with_usual_pressure(node(pressure_hpa=1005.0), usual).usual_pressure_hpa
    assert usual == pytest.approx(1005.0, abs=0.1)
    assert with_usual_pressure(node(pressure_hpa=None), usual).usual_pressure_hpa == usual


def test_the_words_name_node_and_value():
    assert HOT.raised(node(85.4)) == "It is hot at node N1: 85 °C."
    assert TILTED.raised(node(tilt_rad=1.4)) == "Node N1 has been knocked over: it leans by 80 degrees."
    assert PRESSURE.raised(node(pressure_hpa=1009.0)) == "The pressure at node N1 fell by 4.0 hPa."
    assert PRESSURE.raised(node(pressure_hpa=1018.5)) == "The pressure at node N1 rose by 5.5 hPa."
    assert HOT.over(node(44.0)) == "Node N1 has cooled down to 44 °C."
