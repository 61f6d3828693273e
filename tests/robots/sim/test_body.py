from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.config import AntennaConfig, BodyConfig
from robots.se2 import Pose2
from robots.sim.body import ACCELERATION_MPS2, Bodies, inside_solid
from robots.sim.generate import generate
from robots.sim.world import BRICK, GLASS, World

NO_TAGS = np.zeros((0, 2))
DT = 0.05


def bodies(world: World, *poses: tuple[float, float, float], **body: float) -> Bodies:
    return Bodies(world, np.array(poses), BodyConfig(**body), AntennaConfig())


def test_acceleration_and_speed_are_limited(hall):
    team = bodies(hall, (2.0, 3.0, 0.0))
    speeds = [team.tick(np.array([[5.0, 9.0]]), NO_TAGS, DT).speeds[0] for _ in range(20)]
    assert speeds[0][0] == pytest.approx(ACCELERATION_MPS2 * DT)
    assert np.diff([speed[0] for speed in speeds]).max() <= ACCELERATION_MPS2 * DT + 1e-12
    assert speeds[-1] == pytest.approx([0.5, pi / 2])


def test_a_tick_is_an_exact_arc(hall):
    team = bodies(hall, (2.0, 3.0, 0.3))
    pose = Pose2(2.0, 3.0, 0.3)
    for k in range(200):
        speed, turn = team.tick(np.array([[0.4, 0.9 if k % 40 < 30 else -1.2]]), NO_TAGS, DT).speeds[0]
        pose = pose @ Pose2.exp(np.array([speed * DT, 0.0, turn * DT]))
    assert team.poses[0] == pytest.approx(pose.as_array(), abs=1e-12)


def test_straight_into_a_wall_stops_and_presses(hall):
    team = bodies(hall, (8.0, 3.0, 0.0))
    for _ in range(200):
        motion = team.tick(np.array([[0.5, 0.0]]), NO_TAGS, DT)
    assert team.poses[0, 0] == pytest.approx(10.0 - 0.22, abs=1e-3)
    assert motion.pressed[0]
    assert motion.driven_m[0] == pytest.approx(0.0, abs=1e-6)
    assert motion.speeds[0, 0] == 0.5  # the wheels go on turning


def test_slides_along_a_wall(hall):
    team = bodies(hall, (5.0, 0.3, -0.3))
    for _ in range(100):
        team.tick(np.array([[0.5, 0.0]]), NO_TAGS, DT)
    assert team.poses[0, 1] == pytest.approx(0.22, abs=1e-3)
    assert team.poses[0, 0] > 6.5


@pytest.mark.parametrize("kind", [GLASS, BRICK])
def test_glass_and_bricks_stop_bodies(hall, kind):
    cells = hall.cells.copy()
    cells[55:66, 120] = kind
    team = bodies(World(cells, hall.origin_m, hall.resolution_m), (5.0, 3.0, 0.0))
    for _ in range(200):
        team.tick(np.array([[0.5, 0.0]]), NO_TAGS, DT)
    assert team.poses[0, 0] == pytest.approx(120 * 0.05 - 0.05 - 0.22, abs=1e-3)


def test_robots_do_not_pass_through_one_another(hall):
    team = bodies(hall, (4.0, 3.0, 0.0), (6.0, 3.0, pi))
    for _ in range(200):
        motion = team.tick(np.array([[0.5, 0.0], [0.5, 0.0]]), NO_TAGS, DT)
    assert hypot(*(team.poses[0, :2] - team.poses[1, :2])) == pytest.approx(0.44, abs=1e-3)
    assert motion.pressed.all()


def test_slippery_floor_shrinks_the_motion_and_says_so(hall):
    grip = np.ones(hall.cells.shape, np.float32)
    grip[:, 80:] = 0.25
    team = bodies(
        World(hall.cells, hall.origin_m, hall.resolution_m, grip=grip), (2.0, 3.0, 0.0), (6.0, 3.0, 0.0)
    )
    for _ in range(20):
        motion = team.tick(np.array([[0.5, 0.0], [0.5, 0.0]]), NO_TAGS, DT)
    assert motion.driven_m == pytest.approx([0.025, 0.00625])
    assert motion.grip == pytest.approx([1.0, 0.25])


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_never_inside_anything(seed):
    """The collision law: whatever is commanded, no body ever overlaps a wall or another body."""
    rng = np.random.default_rng(seed)
    world = generate("open" if seed % 2 else "office", 60.0, rng)
    rows, columns = np.nonzero(world.reachable(0.25))
    first = world.centre(int(rows[0]), int(columns[0]))
    last = world.centre(int(rows[-1]), int(columns[-1]))
    team = bodies(world, (*first, 0.0), (*last, 1.0), max_speed_mps=float(rng.uniform(0.3, 3.0)))
    for _ in range(40):
        commands = rng.uniform(-1.0, 1.0, (2, 2)) * (3.0, 2.0)
        commands[:, 0] = np.abs(commands[:, 0])
        for _ in range(10):
            team.tick(commands, NO_TAGS, DT)
            for x, y, _theta in team.poses:
                assert not inside_solid(world, x, y, 0.22)
            assert hypot(*(team.poses[0, :2] - team.poses[1, :2])) >= 0.44 - 1e-9


def test_inside_solid_against_brute_force():
    world = generate("open", 40.0, np.random.default_rng(3))
    rng = np.random.default_rng(0)
    solid = np.argwhere(~world.free)
    for x, y in rng.uniform((0.3, 0.3), (5.5, 4.5), (200, 2)):
        low = np.array(world.origin_m) + solid[:, ::-1] * world.resolution_m
        gaps = np.hypot(*(np.array([x, y]) - np.clip((x, y), low, low + world.resolution_m)).T)
        if abs(gaps.min() - 0.22) > 1e-5:
            assert inside_solid(world, x, y, 0.22) == (gaps.min() < 0.22)


@pytest.mark.parametrize("speed", [0.05, 0.5, 3.0])
@pytest.mark.parametrize("across", [0.0, 0.09, -0.099, 0.105])
def test_no_tag_is_passed_over_unseen(hall, speed, across):
    tags = np.array([[5.0, 3.0 + across]])
    team = bodies(hall, (4.0, 3.0, 0.0), max_speed_mps=speed)
    read = [
        team.tick(np.array([[speed, 0.0]]), tags, DT).read[0, 0]
        for _ in range(int((2.0 / speed + speed) / DT))
    ]
    assert any(read) == (abs(across) <= 0.1)
    if any(read):
        assert not read[0]
        assert not read[-1]


def test_a_round_antenna_reads_within_its_radius(hall):
    antenna = AntennaConfig(radius_m=0.15, ahead_m=0.3)
    team = Bodies(hall, np.array([[5.0, 3.0, pi / 2]]), BodyConfig(), antenna)
    tags = np.array([[5.0, 3.3], [5.1, 3.4], [5.0, 3.46], [5.0, 3.0]])
    assert team.tick(np.zeros((1, 2)), tags, DT).read[0].tolist() == [True, True, False, False]
