import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.se2 import Pose2
from robots.sim import wire
from robots.types import (
    Command,
    Displacement,
    DistanceTurn,
    HeatReading,
    ImuReading,
    LaserScan,
    Observation,
    RangeReading,
    RobotSighting,
    TagSighting,
    TagWrite,
    WheelEncoders,
)

finite = st.floats(allow_nan=False, allow_infinity=False)


def there_and_back(observation: Observation) -> Observation:
    return wire.observation_from_wire(
        json.loads(json.dumps(wire.observation_to_wire(observation), allow_nan=False))
    )


def parts(observation: Observation) -> tuple:
    return tuple(getattr(observation, name) for name in Observation.__slots__ if name != "scan")


@given(
    stamp=finite,
    odometry=st.one_of(
        st.none(),
        st.builds(WheelEncoders, finite, finite, finite, finite),
        st.builds(DistanceTurn, finite, finite),
        st.builds(Displacement, finite, finite, finite),
    ),
    imu=st.one_of(st.none(), st.builds(ImuReading, finite, finite, finite)),
    memory=st.binary(max_size=40),
    battery=st.one_of(st.none(), st.floats(0, 1)),
    flags=st.tuples(st.booleans(), st.booleans()),
    seen=st.tuples(finite, finite),
)
def test_observations_survive_bit_for_bit(stamp, odometry, imu, memory, battery, flags, seen):
    observation = Observation(
        seq=3,
        stamp_s=stamp,
        odometry=odometry,
        imu=imu,
        beams=(RangeReading("sonar", 0.1, 1.0 / 3.0, 3.0, 0.5),),
        tag_sightings=(TagSighting("r1-001", memory), TagSighting("BASE"), TagSighting("L6", memory, *seen)),
        robot_sightings=(RobotSighting("r2", *seen),),
        heat=(HeatReading(0.1, 2.0 / 3.0, 0.9),),
        battery=battery,
        tags_left=None if battery is None else 7,
        bumper=flags[0],
        held=flags[1],
    )
    assert parts(there_and_back(observation)) == parts(observation)


@pytest.mark.parametrize("range_max", [4.0, 5.6])
def test_ranges_survive_bit_for_bit_and_far_is_null(range_max):
    rng = np.random.default_rng(0)
    millimetres = np.round(rng.uniform(0.0, range_max - 0.01, 200), 3).astype(np.float32)
    others = rng.uniform(0.0, range_max - 0.01, 200).astype(np.float32)
    far = np.array([range_max + 0.001, np.inf, np.nan], np.float32)
    scan = LaserScan(np.concatenate([millimetres, others, far]), -2.0, 0.01, range_max)
    observation = Observation(0, 0.0, scan=scan)
    ranges = wire.observation_to_wire(observation)["scan"]["ranges_m"]
    assert ranges[400:] == [None, None, None]
    assert max(len(json.dumps(value)) for value in ranges[:200]) <= 5
    back = there_and_back(observation).scan
    assert back is not None
    assert np.array_equal(back.ranges_m[:400], scan.ranges_m[:400])
    assert (back.ranges_m[400:].astype(float) >= range_max).all()
    assert (back.angle_min_rad, back.angle_increment_rad, back.range_max_m) == (-2.0, 0.01, range_max)


def test_commands_and_poses():
    command = Command(0.1 + 0.2, -1e-17, True, (TagWrite("r1-001", b"\x00\xff"), TagWrite("BASE", b"")))
    assert wire.command_from_wire(json.loads(json.dumps(wire.command_to_wire(command)))) == command
    assert wire.pose_to_wire(Pose2(1.0, 2.0, 3.0)) == {"x_m": 1.0, "y_m": 2.0, "yaw_rad": 3.0}


def test_what_is_absent_is_left_out():
    assert wire.observation_to_wire(Observation(1, 2.0)) == {"seq": 1, "stamp_s": 2.0}
