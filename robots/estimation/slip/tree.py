"""The decision trees that tell slippage from normal driving (Kleiner 2006 section IV), as read from a file.

The file is JSON with one node a line; ``python -m robots.sim.physics.train`` writes it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from math import isfinite
from typing import Any

MAX_NODES = 1000


class SlipTreeError(ValueError):
    """A file of slip trees is damaged; the message says where."""


@dataclass(frozen=True, slots=True)
class Node:
    """A question, or an answer where ``feature`` is -1.

    A question goes to node ``then`` if that feature is at most ``at_most``, to node ``otherwise`` if not.
    ``slip`` is the share of slippage in an answer, both classes counting the same as a whole.
    """

    feature: int
    at_most: float = 0.0
    then: int = 0
    otherwise: int = 0
    slip: float = 0.0


@dataclass(frozen=True, slots=True)
class SlipTree:
    """A binary decision tree over ``features``; the first node is the root.

    Slippage is as likely as not at a share of 0.5. An alarm throws a measured distance away, so it is raised
    only by shares beyond ``alarm_above``.
    """

    features: tuple[str, ...]
    nodes: tuple[Node, ...]
    alarm_above: float = 0.5

    def share(self, values: Sequence[float]) -> float:
        """Return the share of slippage where the features, in their order, have these values."""
        node = self.nodes[0]
        while node.feature >= 0:
            node = self.nodes[node.then if values[node.feature] <= node.at_most else node.otherwise]
        return node.slip


@dataclass(frozen=True, slots=True)
class SlipTrees:
    """The tree on the four wheel differences, and the extended one."""

    basic: SlipTree
    extended: SlipTree


def dump_trees(trees: SlipTrees, about: dict[str, Any]) -> str:
    """Return the text of a file: ``about`` says where the trees come from."""
    parts = [f'  "about": {json.dumps(about, indent=4)[:-1].rstrip()}\n  }}']
    for name in ("basic", "extended"):
        tree: SlipTree = getattr(trees, name)
        lines = ",\n".join(f"      {json.dumps(_node_as_json(node, tree.features))}" for node in tree.nodes)
        parts.append(
            f'  "{name}": {{\n    "alarm_above": {tree.alarm_above},\n'
            f'    "features": {json.dumps(tree.features)},\n    "nodes": [\n{lines}\n    ]\n  }}'
        )
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _node_as_json(node: Node, features: Sequence[str]) -> dict[str, Any]:
    if node.feature < 0:
        return {"slip": node.slip}
    name = features[node.feature]
    return {"if": name, "at_most": node.at_most, "then": node.then, "else": node.otherwise}


def parse_trees(text: str, basic: Sequence[str], extended: Sequence[str]) -> SlipTrees:
    """Return the trees of a file; ``basic`` and ``extended`` are the features the program can compute.

    Raises:
        SlipTreeError: as its docstring says.
    """
    try:
        document = json.loads(text)
    except ValueError as error:
        raise SlipTreeError(f"the slip trees are not JSON: {error}") from None
    if not isinstance(document, dict):
        raise SlipTreeError("the slip trees have to be an object")
    return SlipTrees(
        _parse_tree(document.get("basic"), basic, "basic"),
        _parse_tree(document.get("extended"), extended, "extended"),
    )


@lru_cache(maxsize=1)
def _shipped(basic: tuple[str, ...], extended: tuple[str, ...]) -> SlipTrees:
    text = files("robots.estimation.slip").joinpath("tree.json").read_text(encoding="utf-8")
    return parse_trees(text, basic, extended)


def load_trees(basic: Sequence[str], extended: Sequence[str]) -> SlipTrees:
    """Return the trees that come with the program. Raises SlipTreeError as ``parse_trees`` does."""
    return _shipped(tuple(basic), tuple(extended))


def _parse_tree(item: Any, known: Sequence[str], where: str) -> SlipTree:
    if not isinstance(item, dict):
        raise SlipTreeError(f"slip tree {where} is missing")
    if item.get("features") != list(known):
        raise SlipTreeError(f"slip tree {where} has other features than this program computes; train it anew")
    rows = item.get("nodes")
    if not isinstance(rows, list) or not 1 <= len(rows) <= MAX_NODES:
        raise SlipTreeError(f"slip tree {where} has to have 1 to {MAX_NODES} nodes")
    nodes = tuple(
        _parse_node(row, known, k, len(rows), f"node {k} of slip tree {where}") for k, row in enumerate(rows)
    )
    parents = [0] * len(nodes)
    for node in nodes:
        if node.feature >= 0:
            parents[node.then] += 1
            parents[node.otherwise] += 1
    if parents != [0] + [1] * (len(nodes) - 1):
        raise SlipTreeError(f"slip tree {where} is no tree: a node has no parent or several")
    alarm_above = _number(item.get("alarm_above"), f"alarm_above of slip tree {where}")
    return SlipTree(tuple(known), nodes, alarm_above)


def _parse_node(row: Any, known: Sequence[str], at: int, count: int, where: str) -> Node:
    if isinstance(row, dict) and set(row) == {"slip"}:
        slip = _number(row["slip"], where)
        if not 0.0 <= slip <= 1.0:
            raise SlipTreeError(f"{where}: slip has to be a share, 0 to 1")
        return Node(-1, slip=slip)
    if not isinstance(row, dict) or set(row) != {"if", "at_most", "then", "else"}:
        raise SlipTreeError(f"{where} is neither a question nor an answer")
    if row["if"] not in known:
        raise SlipTreeError(f"{where}: there is no feature {row['if']!r}")
    for name in ("then", "else"):
        target = row[name]
        if isinstance(target, bool) or not isinstance(target, int) or not at < target < count:
            raise SlipTreeError(f"{where}: {name} has to be the number of a later node")
    return Node(known.index(row["if"]), _number(row["at_most"], where), row["then"], row["else"])


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise SlipTreeError(f"{where} holds something that is no finite number")
    return float(value)
