from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from robots.codec import encode
from robots.se2 import Pose2
from robots.sim.scenario import ScenarioConfig
from robots.sim.simulation import Order, Simulation
from robots.tags.record import seal
from robots.types import Command, Displacement, TagWrite, WheelEncoders

SMALL = ScenarioConfig(map="open:60", robots=2, victims=2, seed=5)
AHEAD = Command(0.4, 0.3)


def play(config, orders, periods=50):
    simulation = Simulation(config)
    log = []
    for k in range(periods):
        batches = simulation.advance()
        log.append(batches)
        simulation.apply(orders(k, batches))
    return simulation, log


def everyone(command):
    return lambda _k, batches: {name: Order(command) for name in batches}


def test_observations_are_in_order_and_the_last_of_a_period_has_the_scan():
    _, log = play(SMALL, everyone(AHEAD), 5)
    for name in ("r1", "r2"):
        observations = [observation for batches in log for observation in batches[name]]
        assert [observation.seq for observation in observations] == list(range(20))
        assert [observation.stamp_s for observation in observations] == [(k + 1) / 20 for k in range(20)]
        assert [observation.scan is not None for observation in observations] == [
            False,
            False,
            False,
            True,
        ] * 5


def test_the_same_seed_gives_the_same_mission_bit_for_bit():
    config = replace(SMALL, slip=True, sonars=3, infrareds=2)
    logs = [play(config, everyone(AHEAD))[1] for _ in range(2)]
    for one, same in zip(*logs, strict=True):
        for name in one:
            assert [encode(a) for a in one[name]] == [encode(b) for b in same[name]]


def test_robots_do_not_disturb_one_anothers_noise():
    """What r1 measures is the same whether r2 drives, far away, or stands."""
    config = replace(SMALL, map="open:400", start="spread")
    both = play(config, everyone(AHEAD))[1]
    alone = play(config, lambda _k, batches: {"r1": Order(AHEAD)})[1]
    assert [encode(o) for b in both for o in b["r1"]] == [encode(o) for b in alone for o in b["r1"]]
    assert [encode(o) for b in both for o in b["r2"]] != [encode(o) for b in alone for o in b["r2"]]


def test_without_noise_encoders_give_the_true_path():
    config = replace(SMALL, noise_level=0, map="open:300", robots=1)
    track = config.agent_of("r1").body.track_width_m
    pose = None
    commands = [Command(0.5, 0.0), Command(0.2, 1.4), Command(0.0, -1.5), Command(0.4, -0.4)]
    simulation, log = play(config, lambda k, b: {name: Order(commands[k // 5 % 4]) for name in b}, 60)
    pose = simulation.starts[0]
    for observation, truth in zip((o for b in log for o in b["r1"]), simulation.track, strict=True):
        odometry = observation.odometry
        assert isinstance(odometry, WheelEncoders)
        assert not observation.bumper
        distance = (odometry.front_left_m + odometry.front_right_m) / 2
        turn = (odometry.front_right_m - odometry.front_left_m) / track
        pose = pose @ Pose2.exp(np.array([distance, 0.0, turn]))
        assert pose.as_array() == pytest.approx(truth[0], abs=1e-9)


def test_truth_is_exact_even_against_walls_and_on_slippery_floor():
    config = replace(SMALL, poses="truth", slip=True)
    simulation, log = play(config, everyone(Command(0.5, 0.05)), 150)
    pressed = 0
    for index, name in enumerate(("r1", "r2")):
        pose = simulation.starts[index]
        for observation, truth in zip((o for b in log for o in b[name]), simulation.track, strict=True):
            odometry = observation.odometry
            assert isinstance(odometry, Displacement)
            pose = pose @ Pose2(odometry.dx_m, odometry.dy_m, odometry.dtheta_rad)
            assert observation.imu is not None
            assert pose.as_array() == pytest.approx(truth[index], abs=1e-9)
            assert observation.imu.yaw_rad == pytest.approx(truth[index, 2], abs=1e-12)
            pressed += observation.bumper
    assert pressed > 0


def test_held_robots_stop_and_say_so():
    simulation, log = play(SMALL, lambda k, b: {name: Order(AHEAD, held=k >= 20) for name in b}, 40)
    assert not any(o.held for b in log[:21] for o in b["r1"])
    assert all(o.held for b in log[21:] for o in b["r1"])
    assert np.array_equal(simulation.track[-1], simulation.track[-20])
    assert not np.array_equal(simulation.track[60], simulation.track[70])


def test_the_base_tag_lies_under_the_first_robot():
    simulation, log = play(SMALL, everyone(Command()), 2)
    first = log[0]["r1"][0].tag_sightings
    assert [sighting.tag_id for sighting in first] == ["BASE"]
    assert simulation.tags.places_m[0] == pytest.approx((simulation.starts[0].x, simulation.starts[0].y))
    assert play(replace(SMALL, base_tag=False), everyone(Command()), 1)[1][0]["r1"][0].tag_sightings == ()


def test_tags_are_dropped_read_and_written():
    simulation = Simulation(replace(SMALL, base_tag=False))
    simulation.advance()
    simulation.apply({"r1": Order(Command(drop_tag=True))})
    seen = [o for o in simulation.advance()["r1"] if o.tag_sightings]
    assert [sighting.tag_id for sighting in seen[0].tag_sightings] == ["r1-001"]
    assert seen[0].tags_left == simulation.config.agent_of("r1").deployment.magazine - 1
    hello = seal(b"hello", 0, "r1-001", b"")
    simulation.apply(
        {
            "r1": Order(Command(writes=(TagWrite("r1-001", hello),))),
            "r2": Order(Command(writes=(TagWrite("r1-001", b"from afar"),))),
        }
    )
    later = [s for _ in range(6) for o in simulation.advance()["r1"] for s in o.tag_sightings]
    assert [s.memory for s in later] == [hello]
    assert simulation.tags.refused_writes == 1


def test_a_held_robot_drops_nothing():
    simulation = Simulation(replace(SMALL, base_tag=False))
    simulation.apply({"r1": Order(Command(drop_tag=True), held=True)})
    assert simulation.tags.tags == ()


def test_an_empty_battery_stops_a_robot():
    simulation, log = play(SMALL, everyone(AHEAD), 3)
    levels = [o.battery for b in log for o in b["r1"]]
    assert all(a > b for a, b in pairwise(levels))
    simulation._robots[0].battery = 1e-9
    for _ in range(10):
        batches = simulation.advance()
    before = simulation.truth("r1")
    batches = simulation.advance()
    assert simulation.truth("r1") == before
    assert batches["r1"][-1].battery == 0.0


def test_the_map_frame_is_north_up_with_an_imu_and_else_the_start_pose():
    simulation = Simulation(replace(SMALL, start="spread"))
    start = simulation.starts[1]
    assert simulation.world_from_map("r2") == Pose2(start.x, start.y, 0.0)
    blind = Simulation(replace(SMALL, start="spread", imu=False))
    assert blind.world_from_map("r2") == blind.starts[1]
    assert blind.advance()["r2"][0].imu is None


@pytest.mark.parametrize("tags", ["uhf", "node"])
def test_radio_tags_are_heard_the_same_each_time_whoever_else_drives(tags):
    config = replace(SMALL, map="open:400", start="spread", tags=tags, tags_in_place=30)
    both, again = (play(config, everyone(AHEAD), 25)[1] for _ in range(2))
    alone = play(config, lambda _k, batches: {"r1": Order(AHEAD)}, 25)[1]
    heard = [s for batches in both for o in batches["r1"] for s in o.tag_sightings]
    assert sum(s.rssi_dbm is not None for s in heard) > 20
    for other in (again, alone):
        assert [encode(o) for b in both for o in b["r1"]] == [encode(o) for b in other for o in b["r1"]]


def test_only_robots_with_slam_over_floor_tags_read_them_from_above():
    config = replace(SMALL, robots=1, tags="node")  # stands on the base tag
    _, log = play(config, everyone(Command()), 2)
    read = [s for batches in log for o in batches["r1"] for s in o.tag_sightings]
    assert {s.tag_id for s in read if s.under_antenna} == {"BASE"}
