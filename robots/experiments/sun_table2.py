"""Sun 2009 table 2: four robots one after the other outdoors, 282 to 410 m each, among nine nodes.

The paper's place is not printed: ours is an open ground of 2,500 m2, on which every node can be heard from
most places. Positions in the paper were geo-referenced by hand.
"""

from __future__ import annotations

from functools import partial

from robots.experiments.experiment import Experiment
from robots.experiments.sun_plot import draw
from robots.experiments.sun_table1 import COLUMNS, NOTES, PaperRobot, PaperWorld, measure

OUTDOOR = PaperWorld(
    "outdoor",
    "ground",
    2500.0,
    9,
    (
        PaperRobot(8.6, 1.1, 1.1, 410.0),
        PaperRobot(5.0, 2.1, 1.3, 348.0),
        PaperRobot(7.1, 2.2, 1.3, 320.0),
        PaperRobot(5.3, 1.9, 1.5, 282.0),
    ),
)

EXPERIMENT = Experiment(
    name="sun-table2",
    summary="Four robots in sequence outdoors among nine nodes: odometry, RSLAM alone, with others' maps.",
    paper="Sun 2009, table 2",
    default_runs=5,
    run=partial(measure, worlds=(OUTDOOR,)),
    plot=draw,
    columns=COLUMNS,
    notes=NOTES,
)
