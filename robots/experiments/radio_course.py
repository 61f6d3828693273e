"""Robots among radio nodes: true ways, and what they hear and measure.

The air is the simulator's: shadowing fixed for each place, walls that take their part, readings that fade and
sometimes are outliers. Odometry errs at random in distance and turn; how much is one number for each robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan2, hypot, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from robots.config import OdometryConfig, RadioConfig
from robots.estimation.radio.model import NODE
from robots.estimation.radio.signal_mean import robust_mean
from robots.se2 import Array
from robots.sim.channel import Channel
from robots.sim.starts import place_tags
from robots.sim.tags import TagField
from robots.sim.world import World

STEP_M = 0.5  # so far a place's shadowing reaches
READINGS = 10  # of each node at a place
SPIKE_SHARE, SPIKE_DB = 0.05, (10.0, 30.0)
_SURVEY_M = 100.0
_CELL_M, _CLEARANCE_M = 0.5, 0.3
ODOMETRY = OdometryConfig(  # times the level
    distance_sd_per_sqrt_m=0.1, turn_sd_per_sqrt_m=0.05, turn_sd_per_sqrt_rad=0.05, lateral_sd_per_sqrt_m=0.02
)

shortest: Any = dijkstra  # its stubs know no single index


@dataclass(frozen=True, slots=True, eq=False)
class RadioCourse:
    """One robot's way: ``poses`` (n, 3) in the world, and at each the nodes heard and their readings, dBm."""

    poses: Array
    heard: tuple[tuple[tuple[str, Array], ...], ...]

    @property
    def motions(self) -> Array:
        """Distance and turn of each step, (n - 1, 2)."""
        steps = np.diff(self.poses[:, :2], axis=0)
        turns = np.diff(self.poses[:, 2])
        return np.column_stack([np.hypot(steps[:, 0], steps[:, 1]), (turns + pi) % (2.0 * pi) - pi])


class RadioWorld:
    """A world with nodes all over it, and the air between."""

    def __init__(self, world: World, nodes: int, seed: int, random: np.random.Generator) -> None:
        field = TagField(0)
        for number, (x, y) in enumerate(place_tags(world, nodes, 0.3, random)):
            field.drop(f"N{number}", float(x), float(y))
        self._ids = [tag.tag_id for tag in field.tags]
        self._places = field.places_m
        self._channel = Channel(world, field, "node", NODE, seed)
        self._centres, self._lanes = _lanes(world)

    def drive(self, length_m: float, random: np.random.Generator, listen: bool = True) -> RadioCourse:
        """Drive so far by the shortest ways between places drawn at random, and ``listen``."""
        poses = _way(self._centres, self._lanes, length_m, random)
        if not listen:
            return RadioCourse(poses, ((),) * len(poses))
        heard = []
        for x, y, heading in poses:
            signals = self._channel.signals_dbm(self._channel.antennas(x, y, heading))[0]
            audible = np.flatnonzero(np.isfinite(signals))
            heard.append(tuple((self._ids[k], _readings(signals[k], random)) for k in audible))
        return RadioCourse(poses, tuple(heard))

    def survey(self, random: np.random.Generator) -> RadioConfig:
        """Return the path loss that fits what is heard on a drive with all nodes' places known.

        So Sun 2009 section 4 comes to p(d0) and n "in the testing environment": walls on the way are not
        modelled one by one, they make the signal fall faster. What they leave is alike from one place to the
        next, by a correlation r: n readings tell as much as n (1 - r) / (1 + r), which the deviation says.
        """
        course = self.drive(_SURVEY_M, random)
        rows = []
        for step, ((x, y, _), heard) in enumerate(zip(course.poses, course.heard, strict=True)):
            for tag_id, readings in heard:
                mean = robust_mean(readings, NODE.fading_sd_db)
                if mean is not None:
                    number = self._ids.index(tag_id)
                    distance_m = max(float(np.hypot(*(self._places[number] - (x, y)))), STEP_M)
                    rows.append((number, step, np.log10(distance_m), mean.rssi_dbm))
        table = np.array(sorted(rows))
        slope, power = np.polyfit(table[:, 2], table[:, 3], 1)
        off = table[:, 3] - power - slope * table[:, 2]
        after = (np.diff(table[:, 0]) == 0.0) & (np.diff(table[:, 1]) == 1.0)
        alike = float(np.clip(np.corrcoef(off[:-1][after], off[1:][after])[0, 1], 0.0, 0.95))
        spread = float(off.std()) * np.sqrt((1.0 + alike) / (1.0 - alike))
        return replace(
            NODE,
            power_at_1m_dbm=float(power),
            path_loss_exponent=float(-slope / 10.0),
            shadowing_sd_db=float(spread),
            table_distances_m=(),
            table_sds_db=(),
        )


def _readings(signal_dbm: float, random: np.random.Generator) -> Array:
    readings: Array = signal_dbm + NODE.fading_sd_db * random.standard_normal(READINGS)
    spiked = random.random(READINGS) < SPIKE_SHARE
    readings[spiked] += random.uniform(*SPIKE_DB, int(spiked.sum())) * random.choice(
        (-1, 1), int(spiked.sum())
    )
    return readings


def measured(course: RadioCourse, level: float, random: np.random.Generator) -> Array:
    """Return what odometry of a noise level tells of each step, (n - 1, 2)."""
    motions = course.motions
    noise = random.standard_normal(motions.shape)
    distance_sd = ODOMETRY.distance_sd_per_sqrt_m * np.sqrt(motions[:, 0])
    turn_sd = np.sqrt(
        ODOMETRY.turn_sd_per_sqrt_m**2 * motions[:, 0]
        + ODOMETRY.turn_sd_per_sqrt_rad**2 * np.abs(motions[:, 1])
    )
    told: Array = motions + level * noise * np.column_stack([distance_sd, turn_sd])
    return told


def reckoned(course: RadioCourse, told: Array) -> Array:
    """Return where odometry alone has the robot, (n, 2), from its true start."""
    headings = course.poses[0, 2] + np.concatenate([[0.0], np.cumsum(told[:, 1])])
    steps = told[:, :1] * np.column_stack([np.cos(headings[1:]), np.sin(headings[1:])])
    places: Array = course.poses[0, :2] + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    return places


def calibrated(courses: Sequence[RadioCourse], seeds: Sequence[int], error_m: float) -> float:
    """Return the noise level at which dead reckoning errs so much on average over courses (bisection)."""

    def error(level: float) -> float:
        return float(
            np.mean(
                [
                    mean_error_m(reckoned(c, measured(c, level, np.random.default_rng(seed))), c)
                    for c, seed in zip(courses, seeds, strict=True)
                ]
            )
        )

    low, high = 0.0, 1.0
    while error(high) < error_m and high < 64.0:
        high *= 2.0
    for _ in range(30):
        middle = (low + high) / 2.0
        low, high = (middle, high) if error(middle) < error_m else (low, middle)
    return high


def mean_error_m(places: Array, course: RadioCourse) -> float:
    """Return the mean distance from the truth, (n, 2) of places."""
    return float(np.hypot(*(places - course.poses[:, :2]).T).mean())


def _way(centres: Array, steps: Any, length_m: float, random: np.random.Generator) -> Array:
    """Return poses a step apart on shortest ways between places drawn at random."""
    here = int(random.integers(len(centres)))
    line: list[Array] = [centres[here]]
    driven = 0.0
    while driven < length_m:
        goal = int(random.integers(len(centres)))
        _, before = shortest(steps, indices=goal, return_predecessors=True)
        while here != goal and before[here] >= 0:
            here = int(before[here])
            driven += float(np.hypot(*(centres[here] - line[-1])))
            line.append(centres[here])
    corners = np.array(line)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    at = np.arange(0.0, min(length_m, along[-1]), STEP_M)
    x, y = (np.interp(at, along, corners[:, k]) for k in (0, 1))
    headings = [atan2(b, a) for a, b in zip(np.diff(x), np.diff(y), strict=True)]
    return np.column_stack([x, y, [headings[0], *headings]])


def _lanes(world: World) -> tuple[Array, Any]:
    """Return places with room for a robot, (k, 2), all connected, and the ways between neighbours."""
    every = round(_CELL_M / world.resolution_m)
    room = world.distance_cells[every // 2 :: every, every // 2 :: every] * world.resolution_m > _CLEARANCE_M
    rows, columns = np.nonzero(room)
    number = np.full(room.shape, -1)
    number[rows, columns] = np.arange(len(rows))
    pairs: list[NDArray[np.int64]] = []
    lengths: list[Array] = []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        there = np.full(room.shape, -1)
        source = number[down:, max(right, 0) : room.shape[1] + min(right, 0)]
        there[: room.shape[0] - down, max(-right, 0) : room.shape[1] - max(right, 0)] = source
        joined = (number >= 0) & (there >= 0)
        pairs.append(np.column_stack([number[joined], there[joined]]))
        lengths.append(np.full(int(joined.sum()), _CELL_M * hypot(down, right)))
    ends, length = np.concatenate(pairs), np.concatenate(lengths)
    both = np.concatenate([ends, ends[:, ::-1]])
    graph: Any = csr_array((np.tile(length, 2), both.T), shape=(len(rows), len(rows)))
    distances = shortest(graph, indices=len(rows) // 2)
    kept = np.flatnonzero(np.isfinite(distances))
    x0, y0 = world.origin_m
    centres = np.column_stack(
        [x0 + (columns * every + every // 2 + 0.5) * world.resolution_m,
         y0 + (rows * every + every // 2 + 0.5) * world.resolution_m]
    )  # fmt: skip
    return centres[kept], graph[kept][:, kept]
