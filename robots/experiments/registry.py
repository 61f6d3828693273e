"""The experiments there are, by name."""

from __future__ import annotations

from robots.experiments.experiment import Experiment

_ALL: tuple[Experiment, ...] = ()

EXPERIMENTS: dict[str, Experiment] = {experiment.name: experiment for experiment in _ALL}
