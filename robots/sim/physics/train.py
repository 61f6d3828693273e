"""Train the slip trees: ``python -m robots.sim.physics.train --worlds 80 --seed 1 --out FILE``.

Takes about two seconds of one core a world. The same worlds and seed give the same file, as long as MuJoCo
and scikit-learn are of the same versions.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np

from robots.estimation.slip.tree import SlipTrees, dump_trees
from robots.sim.physics.drive import PhysicsError, drive_world
from robots.sim.physics.fit import Lessons, fit_trees, joined, lessons
from robots.sim.physics.kinematic import drive_kinematic
from robots.sim.physics.labels import ROLLING_MPS, SLIP_MPS, SLIP_SHARE

SECONDS = 45.0
_KINEMATIC_SHARE = 0.25  # so many drives of the mission simulator for one of the physical one


def world_seeds(seed: int, count: int) -> list[int]:
    """Return seeds of ``count`` worlds; those of different seeds share none but by a chance of 2^-62."""
    return [int(value) for value in np.random.default_rng([seed, 77]).integers(0, 2**62, count)]


def world_lessons(world: int, seconds: float) -> Lessons:
    """Return what a drive through a world teaches. Raises PhysicsError as ``drive_world`` does."""
    return lessons([drive_world(world, seconds)])


def kinematic_lessons(seeds: Sequence[int], seconds: float) -> Lessons:
    """Return what the mission simulator adds to drives through worlds of these seeds."""
    some = seeds[: max(1, round(len(seeds) * _KINEMATIC_SHARE))]
    return lessons([drive_kinematic(seed, seconds) for seed in some])


def train(
    worlds: int, seed: int, seconds: float = SECONDS, progress: Callable[[int, int], None] | None = None
) -> tuple[SlipTrees, Lessons]:
    """Drive through worlds and return the trees they teach, and what they were taught from.

    Raises:
        PhysicsError: MuJoCo or scikit-learn are not installed, or too little was driven.
    """
    seeds = world_seeds(seed, worlds)
    learnt = []
    for done, world in enumerate(seeds):
        learnt.append(world_lessons(world, seconds))
        if progress is not None:
            progress(done + 1, worlds)
    physical = joined(learnt)
    return fit_trees(physical, kinematic_lessons(seeds, seconds)), physical


def main(arguments: list[str] | None = None) -> int:
    """Train and write the file."""
    parser = argparse.ArgumentParser(prog="python -m robots.sim.physics.train", description=__doc__)
    parser.add_argument("--worlds", type=int, default=80, help="each with its own floor and robot")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of driving in each")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True, help="JSON file to write")
    given = parser.parse_args(arguments)
    try:
        trees, learnt = train(
            given.worlds,
            given.seed,
            given.seconds,
            lambda k, n: print(f"\rworld {k} of {n}", end="", file=sys.stderr),
        )
    except PhysicsError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    about = {
        "what": "slippage of four wheels, Kleiner 2006 section IV; see robots/sim/physics/labels.py",
        "by": f"python -m robots.sim.physics.train --worlds {given.worlds} --seconds {given.seconds:g}"
        f" --seed {given.seed} --out FILE",
        "mujoco": version("mujoco"),
        "scikit_learn": version("scikit-learn"),
        "observations": len(learnt.slips),
        "slip_share": round(float(learnt.slips.mean()), 4),
        "slip_mps": SLIP_MPS,
        "slip_share_of_speed": SLIP_SHARE,
        "rolling_mps": ROLLING_MPS,
    }
    given.out.write_text(dump_trees(trees, about), encoding="utf-8")
    sizes = f"{len(trees.basic.nodes)} and {len(trees.extended.nodes)} nodes"
    print(f"\n{given.out}: {sizes}, {learnt.slips.mean():.1%} of {len(learnt.slips)} observations slip")
    return 0


if __name__ == "__main__":
    sys.exit(main())
