"""The experiment of Ziparo 2007 by three robots for a little while."""

from robots.experiments.experiment import Options
from robots.experiments.ziparo_exploration import METHODS, ROBOCUP_M2, Run, measure, play


def test_rows_hold_our_methods_and_the_paper_s_runs():
    rows = measure(Options(runs=1, maps=("office:60",)), robots=2, minutes=0.5)
    assert [row["method"] for row in rows[: len(METHODS)]] == [name for name, _, _ in METHODS]
    assert len(rows) == len(METHODS) + len(ROBOCUP_M2)
    for row in rows[: len(METHODS)]:
        assert 0.3 < row["coverage_2min"] <= row["coverage_20min"] <= 1.0
    tags = {row["method"]: row["tags"] for row in rows[: len(METHODS)]}
    assert tags["no tags"] == 0
    assert min(tags["private tags"], tags["shared tags"], tags["waymark"]) > 2


def test_with_private_tags_a_robot_drops_more_since_it_reads_no_others():
    shared, private = (play(Run("open:100", "ziparo", sharing, 4, 3, 0.7)) for sharing in ("tags", "private"))
    assert private.tags > shared.tags
    assert private == play(Run("open:100", "ziparo", "private", 4, 3, 0.7))


def test_waymark_is_not_trapped_with_a_small_map():
    assert play(Run("office:100", "waymark", "tags", 1, 3, 2.5)).shares[-1] > 0.9
