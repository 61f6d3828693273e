"""What a robot sends and what the server makes of it are the same observation."""

import json

from hypothesis import given
from hypothesis import strategies as st

from robots.sim.wire import observation_to_wire
from robots.types import HeatReading, NodeSensors, Observation, RangeReading, RobotSighting, TagSighting
from server.schemas.convert import observation_from_wire
from server.schemas.observations import ObservationIn

names = st.from_regex(r"[A-Za-z0-9][A-Za-z0-9._:~-]{0,20}", fullmatch=True)
ranges, bearings = st.floats(0.0, 1000.0), st.floats(-1e4, 1e4)
signals, antennas = st.floats(-200.0, 100.0), st.sampled_from([None, "front", "rear"])
places = st.one_of(
    st.just((None, None)),
    st.tuples(ranges, bearings),
    st.tuples(ranges, st.none(), st.none(), antennas),
    st.tuples(st.none(), st.none(), signals, antennas, st.builds(NodeSensors, signals, ranges, bearings)),
)
tags = st.builds(lambda name, memory, place: TagSighting(name, memory, *place), names, st.binary(), places)
observations = st.builds(
    Observation,
    seq=st.integers(0, 2**53 - 1),
    stamp_s=st.floats(-1e12, 1e12),
    tag_sightings=st.lists(tags, max_size=3).map(tuple),
    robot_sightings=st.lists(st.builds(RobotSighting, names, ranges, bearings), max_size=3).map(tuple),
    beams=st.lists(
        st.builds(RangeReading, st.just("sonar"), bearings, ranges, st.just(3.0), st.just(0.5))
    ).map(tuple),
    heat=st.lists(st.builds(HeatReading, bearings, ranges, st.floats(0.0, 1.0)), max_size=2).map(tuple),
)


@given(observations)
def test_an_observation_arrives_as_it_was_made(observation):
    sent = json.dumps(observation_to_wire(observation), allow_nan=False)
    arrived = observation_from_wire(ObservationIn.model_validate_json(sent))
    for name in Observation.__slots__:
        assert getattr(arrived, name) == getattr(observation, name)
