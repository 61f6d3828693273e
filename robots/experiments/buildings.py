"""The three buildings of Kleiner 2006 section VI, ours by their size, and a robot's courses through them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from robots.experiments.course import Course, explore
from robots.experiments.experiment import ExperimentError
from robots.experiments.parallel import in_parallel
from robots.sim.scenario import ScenarioError
from robots.sim.world import WorldError


@dataclass(frozen=True, slots=True)
class Building:
    """A building of the paper's size: its name there, its free floor there, and what ours is made from."""

    name: str
    paper_area_m2: float
    map: str


GENERATED = (
    Building("small", 263.0, "office:263"),
    Building("normal", 589.0, "office:589"),
    Building("large", 1240.0, "office:1240"),
)
_PLANS = (("small", 263.0, "office-280"), ("normal", 589.0, "office-590"), ("large", 1240.0, "office-1275"))


def plans(data: Path | None) -> tuple[Building, ...]:
    """Return plans of real buildings of about the paper's sizes.

    Raises:
        ExperimentError: they are not there.
    """
    folder = None if data is None else data / "maps"
    found = []
    for name, area_m2, stem in _PLANS:
        path = None if folder is None else folder / f"{stem}.yaml"
        if path is None or not path.is_file():
            raise ExperimentError(
                f"the plan {stem}.yaml is not in {folder}; give a --data DIR that has maps/"
            )
        found.append(Building(name, area_m2, str(path)))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class _Trip:
    map: str
    seed: int
    minutes: float | None
    searches: int


def explore_all(
    buildings: Sequence[Building],
    count: int,
    seed: int,
    jobs: int,
    progress: Callable[[int, int], None],
    searches: int = 2,
    minutes: float | None = None,
) -> dict[str, list[Course]]:
    """Return ``count`` courses through buildings of each kind; each a building of its own where generated.

    Raises:
        ExperimentError: a building cannot be had.
    """
    trips = [
        _Trip(building.map, _seed(seed, index, number), minutes, searches)
        for index, building in enumerate(buildings)
        for number in range(count)
    ]
    largest_first = sorted(range(len(trips)), key=lambda k: -buildings[k // count].paper_area_m2)
    try:
        courses = in_parallel(_course, [trips[k] for k in largest_first], jobs, progress)
    except (WorldError, ScenarioError) as error:
        raise ExperimentError(str(error)) from error
    by_trip = dict(zip(largest_first, courses, strict=True))
    return {
        building.name: [by_trip[index * count + number] for number in range(count)]
        for index, building in enumerate(buildings)
    }


def _seed(seed: int, building: int, number: int) -> int:
    return int(np.random.SeedSequence([seed, building, number]).generate_state(1)[0])


def _course(trip: _Trip) -> Course:
    return explore(trip.map, trip.seed, trip.minutes, trip.searches)


def stage(progress: Callable[[int, int], None], before: int, total: int) -> Callable[[int, int], None]:
    """Return the progress of one stage of ``total`` steps in all, ``before`` of which lie behind it."""
    return partial(_report, progress, before, total)


def _report(progress: Callable[[int, int], None], before: int, total: int, done: int, _of: int) -> None:
    progress(before + done, total)
