"""How robots end, on a building small enough for a test."""

import numpy as np
from PIL import Image

from robots.experiments import endings
from robots.experiments.experiment import Options
from robots.exploration.last_looks import BEHIND_GLASS
from robots.sim.arena.ground import ground_of
from robots.sim.arena.run import Arena
from robots.sim.world import BRICK


def test_rows_say_who_was_stuck_or_done_too_early(tmp_path):
    rows = endings.measure(Options(1, maps=("open:40",)), endings.HARDSHIPS[:1])
    (row,) = rows
    for column in endings.EXPERIMENT.columns:
        assert column.value in row
    assert (row["stuck_runs"], row["false_end_runs"], row["unfinished_runs"], row["wrong"]) == (0, 0, 0, "")
    assert row["coverage"] == row["coverage_least"] > 0.98
    endings.EXPERIMENT.plot(rows, tmp_path / "plot.png")
    with Image.open(tmp_path / "plot.png") as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20


def test_runs_that_ended_badly_are_named_by_their_seeds():
    good = endings.Ending(0, 0, 1.0, 100.0, True)
    bad = endings.Ending(1, 0, 0.9, 200.0, True), endings.Ending(0, 2, 0.8, 300.0, False)
    row = endings._row("hall", endings.HARDSHIPS[0], [7, 8, 9], [good, *bad])
    assert (row["stuck_runs"], row["false_end_runs"], row["unfinished_runs"]) == (1, 1, 1)
    assert (row["wrong"], row["coverage_least"], row["end_s"]) == ("8 9", 0.8, 200.0)


def test_what_was_only_seen_behind_glass_is_gone_to_before_the_end():
    """Its map shows what lies behind glass as free: a robot that trusted it left 1.6 m2 unseen there."""
    glass = next(hard for hard in endings.HARDSHIPS if hard.rubble.glass)
    seed = int(np.random.SeedSequence([0, 2]).generate_state(1)[0])
    config = glass.config("office:100", seed)
    arena = Arena(config, ground_of(config.scenario))
    why, note = set(), arena._note
    arena._note = lambda: (
        why.update(robot.decision.reason.partition(" m to ")[2] for robot in arena.robots),
        note(),
    )
    result = arena.play()
    assert BEHIND_GLASS in why
    assert (result.false_ends, result.times_stuck) == (0, 0)


def test_rubble_lies_in_the_arena():
    hard = next(hard for hard in endings.HARDSHIPS if hard.rubble.bricks)
    clear = endings.HARDSHIPS[0].config("open:60", 3).scenario
    assert (ground_of(hard.config("open:60", 3).scenario).world.cells & BRICK).any()
    assert not (ground_of(clear).world.cells & BRICK).any()
