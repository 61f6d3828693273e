"""Work spread over processes."""

import math
import os

import pytest

from robots.experiments.experiment import ExperimentError
from robots.experiments.parallel import in_parallel


def test_results_keep_the_order_of_the_items():
    seen = []
    items = [float(k) for k in range(12)]
    results = in_parallel(math.sqrt, items, 2, lambda done, total: seen.append((done, total)))
    assert results == [math.sqrt(item) for item in items]
    assert seen == [(done, 12) for done in range(13)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_the_task_raises_comes_through(jobs):
    with pytest.raises(ValueError, match=r"math domain error|nonnegative"):
        in_parallel(math.sqrt, [4.0, -1.0, 9.0], jobs, lambda done, total: None)


def test_a_killed_process_is_one_sentence():
    with pytest.raises(ExperimentError, match="fewer --jobs"):
        in_parallel(os._exit, [3, 3], 2, lambda done, total: None)
