from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest

from robots.se2 import Pose2
from robots.sim.sensors import HeatConfig, Laser, LaserConfig, Ring, ThermalCamera, far_reading, others_near
from robots.sim.world import GLASS, SMOKE, WALL, World

NOBODY = np.zeros((0, 2))


def scan(world, pose, config=None, others=NOBODY, seed=0, seen=None):
    laser = Laser(world, config or LaserConfig(), np.random.default_rng(seed))
    return laser.scan(pose, others, 0.22, np.zeros_like(world.cells) if seen is None else seen)


def test_a_scan_has_the_layout_it_names(hall):
    exact = LaserConfig(sd_m=0.0)
    reading = scan(hall, Pose2(2.0, 3.0, 0.0), exact)
    assert reading.ranges_m.shape == (240,)
    assert reading.ranges_m.dtype == np.float32
    angles = reading.angle_min_rad + reading.angle_increment_rad * np.arange(240)
    assert angles[[0, -1]] == pytest.approx([-radians(120), radians(120)])
    up = int(np.argmin(abs(angles - pi / 2)))
    assert reading.ranges_m[up] == pytest.approx(3.0, abs=0.01)
    assert (reading.ranges_m[119:121] == 4.0).all()  # the far wall is out of reach


def test_noise_is_as_stated_and_ranges_are_in_millimetres(hall):
    config = LaserConfig(field_of_view_rad=0.01, beams=4000, range_max_m=20.0, sd_m=0.01)
    ranges = scan(hall, Pose2(2.0, 3.0, 0.0), config).ranges_m.astype(np.float64)
    assert ranges.mean() == pytest.approx(8.0, abs=0.002)
    assert ranges.std() == pytest.approx(0.01, rel=0.1)
    assert (np.round(ranges, 3).astype(np.float32) == ranges.astype(np.float32)).all()


def test_other_robots_are_seen(hall):
    others = np.array([[4.0, 3.0]])
    reading = scan(hall, Pose2(2.0, 3.0, 0.0), LaserConfig(sd_m=0.0), others)
    assert reading.ranges_m[119:121] == pytest.approx([1.78, 1.78], abs=0.002)


def test_a_far_reading_is_never_below_the_range():
    for range_m in (4.0, 5.6, 0.1, 29.999999):
        far = far_reading(range_m)
        assert float(far) >= range_m
        assert float(np.nextafter(far, np.float32(0))) < range_m


def test_seen_cells_are_marked_where_a_scan_looked(hall):
    seen = np.zeros_like(hall.cells)
    scan(hall, Pose2(5.0, 3.0, 0.0), seen=seen)
    assert seen[hall.cell(7.0, 3.0)] == 1
    assert seen[hall.cell(2.0, 3.0)] == 0  # behind the robot


def ring_world(kind: int) -> World:
    cells = np.full((122, 202), WALL, dtype=np.uint8)
    cells[1:-1, 1:-1] = 0
    cells[:, 100] = kind
    return World(cells, (-0.05, -0.05), 0.05)


@pytest.mark.parametrize(
    ("kind", "sonar", "infrared"), [(WALL, 0.45, 0.45), (GLASS, 0.45, 0.8), (SMOKE, 3.0, 0.8)]
)
def test_sonar_hears_glass_and_infrared_does_not(kind, sonar, infrared):
    ring = Ring(ring_world(kind), 4, 4, np.random.default_rng(0))
    beams = ring.read(Pose2(4.5, 3.0, 0.0), NOBODY, 0.22)
    assert [beam.kind for beam in beams] == ["sonar"] * 4 + ["infrared"] * 4
    assert [beam.bearing_rad for beam in beams[:4]] == pytest.approx([0.0, pi / 2, pi, -pi / 2])
    assert beams[0].range_m == pytest.approx(sonar, abs=0.12)
    assert beams[4].range_m == pytest.approx(infrared, abs=0.08)
    assert all(0.0 < beam.range_m <= beam.range_max_m for beam in beams)


def looks(world, pose, victims, config=None, count=400):
    camera = ThermalCamera(world, config or HeatConfig(false_alarms_per_s=0.0), np.random.default_rng(2))
    return [camera.look(pose, np.array(victims).reshape(-1, 2), 0.2) for _ in range(count)]


def test_a_victim_in_the_cone_is_seen_as_often_and_as_well_as_stated(hall):
    seen = [reading for look in looks(hall, Pose2(5.0, 3.0, 1.0), [(6.0, 4.0)]) for reading in look]
    assert len(seen) == pytest.approx(0.6 * 400, abs=40)
    assert np.mean([reading.range_m for reading in seen]) == pytest.approx(2**0.5, abs=0.02)
    assert np.std([reading.range_m for reading in seen]) == pytest.approx(0.05 * 2**0.5, rel=0.2)
    assert np.mean([reading.bearing_rad for reading in seen]) == pytest.approx(pi / 4 - 1.0, abs=0.01)
    assert np.std([reading.bearing_rad for reading in seen]) == pytest.approx(radians(2.0), rel=0.2)
    assert all(0.5 < reading.confidence <= 1.0 for reading in seen)


@pytest.mark.parametrize("victim", [(8.1, 3.0), (5.0, 5.0), (3.0, 3.0)])
def test_out_of_range_or_cone_nothing_is_seen(hall, victim):
    assert not any(looks(hall, Pose2(5.0, 3.0, 0.0), [victim]))


def test_walls_and_glass_hide_a_victim_and_smoke_does_not():
    pose, victim = Pose2(4.0, 3.0, 0.0), (6.0, 3.0)
    assert not any(looks(ring_world(WALL), pose, [victim]))
    assert not any(looks(ring_world(GLASS), pose, [victim]))
    assert any(looks(ring_world(SMOKE), pose, [victim]))


def test_false_alarms_come_at_their_rate_and_in_front_of_walls(hall):
    config = replace(HeatConfig(), false_alarms_per_s=0.5)
    alarms = [reading for look in looks(hall, Pose2(9.0, 3.0, 0.0), [], config, 2000) for reading in look]
    assert len(alarms) == pytest.approx(0.5 * 0.2 * 2000, rel=0.25)
    assert all(reading.range_m <= 1.0 / np.cos(reading.bearing_rad) + 1e-6 for reading in alarms)
    assert all(abs(reading.bearing_rad) <= config.cone_rad / 2 for reading in alarms)


def test_others_near_leaves_out_the_robot_itself_and_the_far():
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 0.0, 0.0]])
    assert others_near(poses, 0, 4.0).tolist() == [[1.0, 0.0]]
    assert others_near(poses, 2, 4.0).shape == (0, 2)
