"""Whatever is stored comes back as it was, and bytes that were not stored are refused by name."""

import struct

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from robots.codec import CodecError, decode, encode
from robots.se2 import GaussianPose, Pose2
from robots.types import Command, LaserScan, Observation, RobotSighting, TagSighting, TagWrite

any_float = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)
scans = st.builds(
    LaserScan,
    arrays.arrays(np.float32, st.integers(0, 40), elements=st.floats(width=32)),
    any_float,
    any_float,
    any_float,
)


def bits(value: float) -> bytes:
    return b"nan" if np.isnan(value) else struct.pack("<d", value)


@given(any_float, any_float, any_float)
@example(-0.0, 5e-324, 1.7976931348623157e308)
def test_floats_come_back_bit_for_bit(x, y, theta):
    pose = Pose2(x, y, theta)
    back = decode(encode(pose), Pose2)
    assert [bits(v) for v in (back.x, back.y, back.theta)] == [bits(v) for v in (x, y, theta)]


@given(scans)
def test_scans_come_back_bit_for_bit(scan):
    back = decode(encode(scan), LaserScan)
    assert back.ranges_m.dtype == np.float32
    assert back.ranges_m.tobytes() == scan.ranges_m.tobytes()
    assert bits(back.range_max_m) == bits(scan.range_max_m)
    assert back.ranges_m.flags.writeable


@given(
    arrays.arrays(
        st.sampled_from([np.float64, np.float32, np.int64, np.int32, np.int8, np.uint8]),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    )
)
def test_arrays_keep_type_shape_and_bytes(array):
    back = decode(encode(array), np.ndarray)
    assert back.dtype == array.dtype
    assert back.shape == array.shape
    assert back.tobytes() == array.tobytes()


@given(st.text(), st.binary(max_size=300), st.booleans())
def test_text_and_bytes_come_back(name, memory, drop):
    sighting = TagSighting(name, memory)
    assert decode(encode(sighting), TagSighting) == sighting
    command = Command(drop_tag=drop, writes=(TagWrite(name, memory), TagWrite("b", b"")))
    assert decode(encode(command), Command) == command


@given(st.text(), any_float, any_float)
def test_sightings_come_back_bit_for_bit(name, range_m, bearing_rad):
    observation = Observation(
        0,
        0.0,
        tag_sightings=(TagSighting(name, b"", range_m, bearing_rad), TagSighting(name)),
        robot_sightings=(RobotSighting(name, range_m, bearing_rad),),
    )
    back = decode(encode(observation), Observation)
    assert back.tag_sightings[1] == TagSighting(name)
    for seen in (back.tag_sightings[0], back.robot_sightings[0]):
        assert [bits(seen.range_m), bits(seen.bearing_rad)] == [bits(range_m), bits(bearing_rad)]


def test_an_observation_stored_before_sightings_had_ranges_is_read():
    stored = b'{"_":"Observation","seq":0,"stamp_s":1.0,"tag_sightings":[{"_":"TagSighting","tag_id":"A"}]}'
    assert decode(stored, Observation).tag_sightings == (TagSighting("A"),)


@given(st.binary(max_size=80))
def test_bytes_that_were_never_stored_are_refused(data):
    try:
        found = decode(data, Pose2)
    except CodecError:
        return
    raise AssertionError(f"decoded {data!r} to {found}")


@given(st.integers(0, 10_000), st.integers(0, 255))
def test_a_changed_byte_is_refused_or_still_a_value_of_the_class(at, byte):
    data = bytearray(encode(GaussianPose(Pose2(1.0, 2.0, 0.5), np.eye(3))))
    data[at % len(data)] = byte
    try:
        found = decode(bytes(data), GaussianPose)
    except CodecError:
        return
    assert isinstance(found, GaussianPose)


@given(st.integers(0, 10_000))
def test_every_truncation_is_refused(at):
    data = encode(GaussianPose(Pose2(1.0, 2.0, 0.5), np.eye(3)))
    try:
        decode(data[: at % len(data)], GaussianPose)
    except CodecError:
        return
    raise AssertionError("half a value was decoded")
