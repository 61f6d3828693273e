"""The physical robot against mechanics: it scrubs, spins and stalls as it must; and what it teaches."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from robots.estimation.slip.detector import SlipDetector
from robots.estimation.slip.features import BASIC_FEATURES, EXTENDED_FEATURES
from robots.estimation.slip.tree import parse_trees
from robots.se2 import Pose2
from robots.sim.physics.build import TRACK_M, WHEELBASE_M, draw_build
from robots.sim.physics.drive import PhysicsError, drive, drive_world
from robots.sim.physics.fit import judge
from robots.sim.physics.floor import Floor, draw_floor
from robots.sim.physics.labels import true_motion
from robots.sim.physics.train import main, world_seeds

NO_PATCHES, FLAT = np.zeros((0, 4)), np.zeros((0, 5))


@pytest.fixture(autouse=True)
def _physics():
    pytest.importorskip("mujoco", reason="MuJoCo is not installed; it comes with the extra `physics`")


class Steady:
    """A driver who holds one command."""

    def __init__(self, speed: float, turn: float) -> None:
        self.command = speed, turn

    def decide(self, pose: Pose2) -> tuple[float, float]:
        return self.command


def build(**changes):
    nothing = {"obstacles": np.zeros((0, 3)), "crates": np.zeros((0, 3))}
    even = {"motor_gains": np.ones(4), "encoder_gains": np.ones(4), "centre_m": (0.0, 0.0, 0.1)}
    return replace(draw_build(np.random.default_rng(1)), **{**nothing, **even, "turn_factor": 1.0, **changes})


def driven(speed, turn, seconds=3.0, friction=0.9, slopes=FLAT, **changes):
    floor = Floor(friction, NO_PATCHES, slopes)
    return drive(floor, build(**changes), Steady(speed, turn), seconds, np.random.default_rng(2))


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_on_the_spot_it_scrubs_as_coulomb_has_it(friction):
    """With wheels b beside and a before the middle friction balances at b^2 / (a^2 + b^2) of their turn."""
    run = driven(0.0, 1.2, friction=friction)
    half = len(run.stamps_s) // 2
    turned = np.unwrap(run.poses[:, 2])[-1] - np.unwrap(run.poses[:, 2])[half]
    sides = run.true_rolled_m[half:].sum(axis=0)
    by_wheels = (sides[1] + sides[3] - sides[0] - sides[2]) / 2.0 / TRACK_M
    a, b = WHEELBASE_M / 2.0, TRACK_M / 2.0
    assert turned / by_wheels == pytest.approx(b**2 / (a**2 + b**2), abs=0.06)
    assert not true_motion(run).slips.any()


def test_on_firm_floor_it_goes_where_its_wheels_roll_and_encoders_count_it():
    run = driven(0.4, 0.0)
    way = np.hypot(*(run.poses[-1, :2] - run.poses[0, :2]))
    assert run.true_rolled_m.mean(axis=1).sum() == pytest.approx(way, rel=0.01)
    per_tick = 2.0 * np.pi * 0.08 / build().ticks_per_turn
    np.testing.assert_allclose(
        run.rolled_m[1:].sum(axis=0), run.true_rolled_m[1:].sum(axis=0), atol=1.01 * per_tick
    )
    assert not true_motion(run).slips.any()


def test_motors_droop_under_load_and_run_free_without_grip():
    slope = np.array([[0.0, 0.0, 9.0, 0.15, 0.0]])  # uphill along x
    level, uphill, ice = (driven(0.3, 0.0, **given) for given in ({}, {"slopes": slope}, {"friction": 0.05}))
    speeds = [true_motion(run).wheels_mps[30:].mean() for run in (level, uphill, ice)]
    assert speeds[1] < speeds[0] - 0.02
    assert speeds[2] > speeds[1] + 0.02


def test_pushing_against_a_wall_the_wheels_spin():
    wall = np.array([[0.75, 0.0, 0.4]])
    run = driven(0.4, 0.0, seconds=4.0, friction=0.35, obstacles=wall)
    late = true_motion(run).slips[-30:]
    assert late.mean() > 0.95
    assert np.ptp(run.poses[-30:, 0]) < 0.05


def test_on_a_slope_steeper_than_friction_holds_it_slides_back():
    slope = np.array([[0.0, 0.0, 9.0, 0.25, 0.0]])
    run = driven(0.3, 0.0, friction=0.12, slopes=slope)
    assert run.poses[-1, 0] < -0.1
    assert true_motion(run).slips[-20:].mean() > 0.9


def test_a_world_is_its_seed():
    one, same, other = drive_world(7, 4.0), drive_world(7, 4.0), drive_world(8, 4.0)
    for name in ("stamps_s", "rolled_m", "yaws_rad", "commands", "poses", "true_rolled_m"):
        assert np.array_equal(getattr(one, name), getattr(same, name))
    assert not np.array_equal(one.poses[:20], other.poses[:20])
    builds = [draw_build(np.random.default_rng([seed, 1])) for seed in (7, 8)]
    assert not np.allclose(builds[0].encoder_gains, builds[1].encoder_gains)
    floors = [draw_floor(np.random.default_rng([seed, 0])) for seed in (7, 8)]
    assert not np.allclose(floors[0].patches[:5], floors[1].patches[:5])
    assert not set(world_seeds(1, 500)) & set(world_seeds(2, 500))


def test_gains_and_floors_are_spread_as_stated():
    builds = [draw_build(np.random.default_rng(seed)) for seed in range(200)]
    gains = np.array([[b.motor_gains, b.encoder_gains] for b in builds])
    assert np.abs(gains - 1.0).max() <= 0.1
    assert 0.035 < gains.std() < 0.06
    floors = [draw_floor(np.random.default_rng(seed)) for seed in range(50)]
    frictions = np.concatenate([floor.patches[:, 3] for floor in floors])
    assert frictions.min() < 0.12
    assert frictions.max() > 0.35
    points = np.random.default_rng(0).uniform(-3.5, 3.5, (500, 2))
    slick = np.mean([floor.friction(points) < 0.45 for floor in floors])
    assert 0.1 < slick < 0.5


def test_the_trees_that_come_with_the_program_know_worlds_they_have_not_seen():
    said, slips = [], []
    for seed in world_seeds(424_242, 3):
        run = drive_world(seed, 15.0)
        detector = SlipDetector()
        for sample in run.samples():
            said.append(detector.observe(sample.stamp_s, sample.odometry, sample.imu, sample.command))
        slips.append(true_motion(run).slips)
    verdict = judge(np.array(said), np.concatenate(slips))
    assert verdict.balanced_accuracy > 0.8
    assert verdict.false_alarm_rate < 0.1


def test_training_writes_a_file_the_agent_reads(tmp_path, capsys):
    pytest.importorskip("sklearn", reason="scikit-learn is not installed; it comes with the extra `physics`")
    out = tmp_path / "trees.json"
    assert main(["--worlds", "4", "--seconds", "9", "--seed", "3", "--out", str(out)]) == 0
    trees = parse_trees(out.read_text(), BASIC_FEATURES, EXTENDED_FEATURES)
    assert len(trees.extended.nodes) > 1
    assert "nodes" in capsys.readouterr().out


def test_without_mujoco_it_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(PhysicsError, match="physics"):
        drive_world(1, 1.0)
    assert main(["--worlds", "1", "--out", str(tmp_path / "x.json")]) == 1
    assert "pip install" in capsys.readouterr().err
