"""From drives to trees: the detector's own features, the true labels, scikit-learn's CART."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.estimation.slip.detector import SlipDetector
from robots.estimation.slip.features import BASIC_FEATURES, EXTENDED_FEATURES
from robots.estimation.slip.tree import Node, SlipTree, SlipTrees
from robots.se2 import Array
from robots.sim.physics.drive import Drive, PhysicsError
from robots.sim.physics.labels import true_motion

BASIC_LEAVES, BASIC_ALARM = 28, 0.8
EXTENDED_LEAVES, EXTENDED_ALARM = 64, 0.8  # where drift on worlds apart was least
_LEAF_SHARE = 0.0015  # of the training set: an answer that rests on less is chance
_DIGITS = 3


@dataclass(frozen=True, slots=True, eq=False)
class Lessons:
    """What trees learn from: ``basic`` (n, 4) and ``extended`` (n, e) features, ``slips`` (n,) labels."""

    basic: Array
    extended: Array
    slips: NDArray[np.bool_]


_NO_TREES = SlipTrees(SlipTree(BASIC_FEATURES, (Node(-1),)), SlipTree(EXTENDED_FEATURES, (Node(-1),)))


def lessons(drives: Sequence[Drive]) -> Lessons:
    """Return features and labels of drives, where the detector has a full set of features."""
    basic, extended, slips = [], [], []
    for drive in drives:
        detector = SlipDetector("extended", _NO_TREES)
        for sample, slipped in zip(drive.samples(), true_motion(drive).slips, strict=True):
            detector.observe(sample.stamp_s, sample.odometry, sample.imu, sample.command)
            values = detector.values()
            if values[0] is not None and values[1] is not None:
                basic.append(values[0])
                extended.append(values[1])
                slips.append(slipped)
    return Lessons(np.array(basic), np.array(extended), np.array(slips))


def joined(parts: Sequence[Lessons]) -> Lessons:
    """Return several lessons as one."""
    return Lessons(
        np.concatenate([part.basic for part in parts]),
        np.concatenate([part.extended for part in parts]),
        np.concatenate([part.slips for part in parts]),
    )


def fit_trees(physical: Lessons, kinematic: Lessons | None = None) -> SlipTrees:
    """Return trees that weigh both classes alike.

    The extended one learns from ``kinematic`` drives too; on four differences of one moment those of noisy
    encoders only confuse (0.72 instead of 0.75 balanced accuracy).

    Raises:
        PhysicsError: scikit-learn is not installed, or the drives hold no slippage to learn from.
    """
    both = physical if kinematic is None else joined([physical, kinematic])
    return SlipTrees(
        _fit(physical.basic, physical.slips, BASIC_FEATURES, BASIC_LEAVES, BASIC_ALARM),
        _fit(both.extended, both.slips, EXTENDED_FEATURES, EXTENDED_LEAVES, EXTENDED_ALARM),
    )


def boosted_verdict(taught: Lessons, asked: Lessons) -> Verdict:
    """Return how boosting (150 trees) on the basic tree's four inputs does: about what is in those inputs.

    Raises:
        PhysicsError: scikit-learn is not installed.
    """
    try:
        from sklearn.ensemble import HistGradientBoostingClassifier
    except ImportError:
        raise PhysicsError(
            "boosting needs scikit-learn; install it by pip install 'waymark[physics]'"
        ) from None
    many = HistGradientBoostingClassifier(
        max_iter=150, learning_rate=0.08, class_weight="balanced", random_state=0
    )
    many.fit(taught.basic, taught.slips)
    return judge(np.asarray(many.predict(asked.basic), bool), asked.slips)


def _fit(
    features: Array, slips: NDArray[np.bool_], names: tuple[str, ...], leaves: int, alarm: float
) -> SlipTree:
    try:
        from sklearn.tree import DecisionTreeClassifier
    except ImportError:
        raise PhysicsError(
            "fitting trees needs scikit-learn; install it by pip install 'waymark[physics]'"
        ) from None
    if not slips.any() or slips.all():
        raise PhysicsError("the drives hold only one of slippage and normal driving; drive more worlds")
    tree = DecisionTreeClassifier(
        max_leaf_nodes=leaves,
        min_samples_leaf=max(5, round(_LEAF_SHARE * len(slips))),
        class_weight="balanced",
        random_state=0,
    )
    tree.fit(features, slips)
    return SlipTree(names, _nodes(tree.tree_), alarm)


def _nodes(fitted: Any) -> tuple[Node, ...]:
    """Return the nodes in scikit-learn's order (depth first), thresholds rounded."""

    def build(at: int) -> list[Node]:
        if fitted.children_left[at] < 0:
            normal, slip = fitted.value[at][0]
            return [Node(-1, slip=round(float(slip / (normal + slip)), _DIGITS))]
        then, otherwise = build(fitted.children_left[at]), build(fitted.children_right[at])
        question = Node(
            int(fitted.feature[at]), round(float(fitted.threshold[at]), _DIGITS), 1, 1 + len(then)
        )
        return [question, *_moved(then, 1), *_moved(otherwise, 1 + len(then))]

    return tuple(build(0))


def _moved(nodes: list[Node], by: int) -> list[Node]:
    return [
        node
        if node.feature < 0
        else Node(node.feature, node.at_most, node.then + by, node.otherwise + by, node.slip)
        for node in nodes
    ]


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a tree does: ``miss_rate`` of slippage, ``false_alarm_rate`` of normal driving."""

    miss_rate: float
    false_alarm_rate: float

    @property
    def balanced_accuracy(self) -> float:
        """Return the mean of both classes' accuracies."""
        return 1.0 - (self.miss_rate + self.false_alarm_rate) / 2.0


def judge(said: NDArray[np.bool_], slips: NDArray[np.bool_]) -> Verdict:
    """Return how far verdicts (n,) are from the truth (n,); NaN where a class does not occur."""
    miss = float(np.mean(~said[slips])) if slips.any() else float("nan")
    alarm = float(np.mean(said[~slips])) if (~slips).any() else float("nan")
    return Verdict(miss, alarm)
