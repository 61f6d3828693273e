"""Where am I, by what I hear: on what a robot of the simulator really mapped."""

from math import hypot, log10
from types import SimpleNamespace

import numpy as np
import pytest

from robots.config import RadioConfig
from robots.estimation.radio.hearing import Ears
from server.mission.locating import ears_of


@pytest.fixture
def tags(driven):
    return {tag["tag_id"]: (tag["x_m"], tag["y_m"]) for tag in driven.get("/tags")["tags"]}


def ask(driven, heard, language="en", **more):
    found = driven.call("POST", f"/where?language={language}", {"heard": heard, **more})
    assert found.status_code == 200, found.text
    return found.json()


def far(tags, name, here):
    return hypot(tags[name][0] - here[0], tags[name][1] - here[1])


def spread(tags):
    """Three tags that make the largest triangle."""
    names = sorted(tags)
    triangles = [(a, b, c) for a in names for b in names for c in names if a < b < c]

    def area(t):
        (ax, ay), (bx, by), (cx, cy) = (tags[name] for name in t)
        return abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))

    return max(triangles, key=area)


def test_three_ranges_tell_where_one_is_in_numbers_and_words(driven, tags):
    three = spread(tags)
    here = (sum(tags[name][0] for name in three) / 3, sum(tags[name][1] for name in three) / 3)
    heard = [{"node_id": name, "range_m": far(tags, name, here)} for name in three]
    found = ask(driven, heard)
    place = found["places"][0]
    assert hypot(place["x_m"] - here[0], place["y_m"] - here[1]) < 0.5
    assert place["share"] > 0.9
    assert 0.0 < place["right_to_m"] < 3.0
    assert (found["fits"], found["left_out"], found["unknown"], found["ring"]) == (True, [], [], None)
    nearest = min(tags, key=lambda name: far(tags, name, (place["x_m"], place["y_m"])))
    assert place["tag_id"] == nearest
    assert found["text"].startswith("You are ")
    assert f"tag {nearest}" in found["text"]
    assert ask(driven, heard, "de")["text"].startswith("Sie sind ")


def test_signals_tell_too_and_repeated_ones_count_once_a_node(driven, tags):
    three = spread(tags)
    here = (sum(tags[name][0] for name in three) / 3, sum(tags[name][1] for name in three) / 3)
    signals = [
        {"node_id": name, "rssi_dbm": -12.0 - 20.0 * log10(far(tags, name, here)) + off}
        for name in three
        for off in (0.3, -0.3, 0.1)
    ]
    found = ask(driven, signals)
    sure = ask(driven, signals, last_tag=three[0], steps=0)
    assert found["places"][0]["right_to_m"] > sure["places"][0]["right_to_m"]
    assert (
        hypot(sure["places"][0]["x_m"] - tags[three[0]][0], sure["places"][0]["y_m"] - tags[three[0]][1]) < 2
    )


def test_one_node_is_a_ring_and_strange_ones_are_named(driven, tags):
    name = sorted(tags)[0]
    found = ask(driven, [{"node_id": name, "range_m": 4.0}, {"node_id": "moon", "rssi_dbm": -40.0}])
    assert found["places"] == []
    assert (found["ring"]["node_id"], found["ring"]["range_m"]) == (name, pytest.approx(4.0))
    assert found["unknown"] == ["moon"]
    assert f"about 4 m from node {name}, in any direction" in found["text"]
    assert "Node moon is not on the map." in found["text"]


def test_what_cannot_be_used_is_refused_in_words(driven, tags):
    name = sorted(tags)[0]

    def refused(heard, **more):
        return driven.refused("POST", "/where", {"heard": heard, **more})

    assert refused([]) == (422, "invalid", "heard")
    assert refused([{"node_id": name}])[:2] == (422, "invalid")
    assert refused([{"node_id": name, "rssi_dbm": -40.0, "range_m": 1.0}])[:2] == (422, "invalid")
    assert refused([{"node_id": name, "rssi_dbm": 4000.0}])[:2] == (422, "invalid")
    assert refused([{"node_id": name, "range_m": 1.0}], steps=4)[:2] == (422, "invalid")
    assert refused([{"node_id": name, "range_m": 1.0}], last_tag="none", steps=4)[:2] == (404, "unknown_tag")
    assert refused([{"node_id": "moon", "range_m": 1.0}]) == (409, "nothing_heard", "heard")
    apart = [{"node_id": name, "rssi_dbm": rssi} for rssi in (-20.0, -60.0, -100.0)]
    assert refused(apart) == (409, "nothing_heard", "heard")
    body = '{"heard": [{"node_id": "NAME", "rssi_dbm": NaN}]}'.replace("NAME", name)
    assert (
        driven.control.call("POST", f"/missions/{driven.mission_id}/where", content=body).status_code == 422
    )


def test_the_radio_is_the_robots_with_what_they_have_learnt_of_it():
    def robot(power, slam, graph=None):
        return SimpleNamespace(
            ears=Ears(RadioConfig(power_at_1m_dbm=power)), slam=slam, graph=graph and SimpleNamespace(**graph)
        )

    assert ears_of([]) == ears_of([robot(-12.0, "tag-graph")]) == Ears()
    assert ears_of([robot(-31.0, "tag-graph")]).radio.power_at_1m_dbm == -31.0
    assert ears_of([robot(-31.0, "tag-graph"), robot(-40.0, "rslam")]).radio.power_at_1m_dbm == -40.0
    heard = {"range_pairs": np.zeros((3, 2)), "tag_ids": ("N1", "N2")}
    first = robot(-50.0, "rslam", heard | {"range_scale": 1.1, "range_offsets_m": np.array([0.4, 0.01])})
    second = robot(-50.0, "rslam", heard | {"range_scale": 1.2, "range_offsets_m": np.array([0.6, 0.0])})
    ears = ears_of([robot(-31.0, "tag-graph"), first, second])
    assert (ears.radio.power_at_1m_dbm, ears.scale, ears.offsets_m) == (-50.0, 1.15, {"N1": 0.5})
