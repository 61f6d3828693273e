"""The file that holds the slip trees: what is written comes back, and damaged files are refused."""

import json
from importlib.resources import files
from itertools import pairwise

import pytest

from robots.estimation.slip.features import (
    BASIC_FEATURES,
    EXTENDED_FEATURES,
)
from robots.estimation.slip.tree import SlipTreeError, dump_trees, load_trees, parse_trees


def shipped() -> str:
    return files("robots.estimation.slip").joinpath("tree.json").read_text(encoding="utf-8")


def test_the_trees_that_come_with_the_program_are_small_and_readable():
    trees = load_trees(BASIC_FEATURES, EXTENDED_FEATURES)
    assert 5 < len(trees.basic.nodes) < 60
    assert 5 < len(trees.extended.nodes) < 150
    assert max(map(len, shipped().splitlines())) < 700
    about = json.loads(shipped())["about"]
    assert about["by"].startswith("python -m robots.sim.physics.train")
    for tree in (trees.basic, trees.extended):
        assert {node.feature for node in tree.nodes} <= set(range(-1, len(tree.features)))


def test_a_file_holds_what_was_written_to_it():
    trees = load_trees(BASIC_FEATURES, EXTENDED_FEATURES)
    assert parse_trees(dump_trees(trees, {"what": "x"}), BASIC_FEATURES, EXTENDED_FEATURES) == trees


def test_a_tree_answers_by_its_questions():
    text = json.dumps(
        {
            name: {
                "alarm_above": 0.8,
                "features": list(features),
                "nodes": [
                    {"if": features[1], "at_most": 0.5, "then": 1, "else": 2},
                    {"slip": 0.7},
                    {"slip": 0.9},
                ],
            }
            for name, features in (("basic", BASIC_FEATURES), ("extended", EXTENDED_FEATURES))
        }
    )
    tree = parse_trees(text, BASIC_FEATURES, EXTENDED_FEATURES).basic
    assert [tree.share([0.0, x, 0.0, 0.0]) for x in (0.5, 0.51)] == [0.7, 0.9]
    assert [tree.share([0.0, x, 0.0, 0.0]) > tree.alarm_above for x in (0.5, 0.51)] == [False, True]


DAMAGE = {
    "not JSON": lambda d: "{",
    "no object": lambda d: "[]",
    "no extended tree": lambda d: json.dumps({"basic": d["basic"]}),
    "other features": lambda d: json.dumps({**d, "basic": {**d["basic"], "features": ["x"]}}),
    "no nodes": lambda d: json.dumps({**d, "basic": {**d["basic"], "nodes": []}}),
    "no threshold of alarm": lambda d: json.dumps({**d, "basic": {**d["basic"], "alarm_above": None}}),
    "a loop": lambda d: with_node(d, {"then": 0}),
    "a child beyond the end": lambda d: with_node(d, {"else": 10_000}),
    "two parents": lambda d: with_node(d, {"else": 1}),
    "an unknown feature": lambda d: with_node(d, {"if": "height_m"}),
    "a threshold that is no number": lambda d: with_node(d, {"at_most": "0.1"}),
    "a threshold that is NaN": lambda d: with_node(d, {"at_most": float("nan")}),
    "a share beyond 1": lambda d: with_node(d, {"slip": 1.5}, replace=True),
    "a foreign node": lambda d: with_node(d, {"run": "x"}, replace=True),
}


def with_node(document, change, replace=False):
    nodes = list(document["basic"]["nodes"])
    nodes[0] = change if replace else {**nodes[0], **change}
    return json.dumps({**document, "basic": {**document["basic"], "nodes": nodes}})


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_a_damaged_file_is_refused_in_one_sentence(damage):
    with pytest.raises(SlipTreeError) as caught:
        parse_trees(damage(json.loads(shipped())), BASIC_FEATURES, EXTENDED_FEATURES)
    assert "slip tree" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_cut_off_file_is_refused_wherever_it_ends():
    text = shipped().rstrip()
    cuts = [0, *range(1, len(text), len(text) // 40)]
    for _, cut in pairwise([0, *cuts]):
        with pytest.raises(SlipTreeError):
            parse_trees(text[:cut], BASIC_FEATURES, EXTENDED_FEATURES)
