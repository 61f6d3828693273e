"""One short course through a small building, shared: a search takes seconds."""

import pytest

from robots.experiments.course import Course, explore


@pytest.fixture(scope="session")
def course() -> Course:
    return explore("office:60", 3, minutes=2.5, searches=2)
