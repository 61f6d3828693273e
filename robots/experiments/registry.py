"""The experiments there are, by name."""

from __future__ import annotations

from robots.experiments import (
    amigoni,
    baselines,
    consistency,
    endings,
    kleiner_cellar,
    kleiner_exploration,
    kleiner_slam,
    kleiner_time,
    one_robot,
    slip,
    sun_radio,
    sun_table1,
    sun_table2,
    tag_capacity,
    ziparo_exploration,
    ziparo_table2,
)
from robots.experiments.experiment import Experiment

_ALL: tuple[Experiment, ...] = (
    kleiner_slam.EXPERIMENT,
    kleiner_slam.ON_PLANS,
    kleiner_time.EXPERIMENT,
    kleiner_cellar.EXPERIMENT,
    kleiner_exploration.EXPERIMENT,
    tag_capacity.EXPERIMENT,
    tag_capacity.SWEEP,
    baselines.EXPERIMENT,
    endings.EXPERIMENT,
    one_robot.EXPERIMENT,
    slip.EXPERIMENT,
    sun_radio.EXPERIMENT,
    sun_table1.EXPERIMENT,
    sun_table2.EXPERIMENT,
    ziparo_table2.EXPERIMENT,
    ziparo_exploration.EXPERIMENT,
    amigoni.EXPERIMENT,
    consistency.EXPERIMENT,
)

EXPERIMENTS: dict[str, Experiment] = {experiment.name: experiment for experiment in _ALL}
