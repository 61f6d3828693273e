"""The one place where wire models become the values of ``robots.types``, and back."""

from __future__ import annotations

import base64
from math import inf
from typing import Any

import numpy as np

from robots.orders import Methods, RobotOrder
from robots.se2 import Pose2
from robots.types import (
    Command,
    Displacement,
    DistanceTurn,
    HeatReading,
    ImuReading,
    LaserScan,
    NodeSensors,
    Observation,
    Odometry,
    RangeReading,
    RobotSighting,
    TagSighting,
    TagWrite,
    WheelEncoders,
)
from server.schemas.observations import (
    CommandWire,
    DistanceTurnWire,
    ImuWire,
    ObservationIn,
    ScanWire,
    TagSightingWire,
    WheelsWire,
)
from server.schemas.orders import RobotOrderWire


def observation_from_wire(wire: ObservationIn) -> Observation:
    """Return the observation that was sent."""
    return Observation(
        seq=wire.seq,
        stamp_s=wire.stamp_s,
        odometry=_odometry(wire),
        imu=None if wire.imu is None else _imu(wire.imu),
        scan=None if wire.scan is None else _scan(wire.scan),
        beams=tuple(
            RangeReading(beam.kind, beam.bearing_rad, beam.range_m, beam.range_max_m, beam.cone_rad)
            for beam in wire.beams
        ),
        tag_sightings=tuple(_tag(sighting) for sighting in wire.tag_sightings),
        robot_sightings=tuple(
            RobotSighting(sighting.robot_id, sighting.range_m, sighting.bearing_rad)
            for sighting in wire.robot_sightings
        ),
        heat=tuple(
            HeatReading(reading.bearing_rad, reading.range_m, reading.confidence) for reading in wire.heat
        ),
        battery=wire.battery,
        tags_left=wire.tags_left,
        bumper=wire.bumper,
        held=wire.held,
        orders=tuple(_order(order) for order in wire.orders),
        heard=tuple(base64.b64decode(message) for message in wire.heard),
    )


def command_to_wire(command: Command) -> dict[str, Any]:
    """Return the JSON object of a command."""
    return {
        "linear_mps": command.linear_mps,
        "angular_radps": command.angular_radps,
        "drop_tag": command.drop_tag,
        "writes": [
            {"tag_id": write.tag_id, "memory": base64.b64encode(write.memory).decode()}
            for write in command.writes
        ],
        "say": None if command.say is None else base64.b64encode(command.say).decode(),
    }


def command_from_wire(wire: CommandWire) -> Command:
    """Return the command that was sent."""
    writes = tuple(TagWrite(write.tag_id, base64.b64decode(write.memory)) for write in wire.writes)
    say = None if wire.say is None else base64.b64decode(wire.say)
    return Command(wire.linear_mps, wire.angular_radps, wire.drop_tag, writes, say)


def order_to_wire(order: RobotOrder) -> dict[str, Any]:
    """Return the JSON object of an order as its robot is told."""
    x_m, y_m = (None, None) if order.place_m is None else order.place_m
    methods = {name: getattr(order.methods, name) for name in Methods.__slots__}
    return {
        "order_id": order.order_id,
        "kind": order.kind,
        "by": order.by,
        "x_m": x_m,
        "y_m": y_m,
        "area_m": [list(corner) for corner in order.area_m],
        **methods,
    }


def pose_to_wire(pose: Pose2) -> dict[str, float]:
    """Return the JSON object of a pose."""
    return {"x_m": pose.x, "y_m": pose.y, "yaw_rad": pose.theta}


def _odometry(wire: ObservationIn) -> Odometry | None:
    odometry = wire.odometry
    if odometry is None:
        return None
    if isinstance(odometry, WheelsWire):
        return WheelEncoders(
            odometry.front_left_m, odometry.front_right_m, odometry.rear_left_m, odometry.rear_right_m
        )
    if isinstance(odometry, DistanceTurnWire):
        return DistanceTurn(odometry.distance_m, odometry.turn_rad)
    return Displacement(odometry.dx_m, odometry.dy_m, odometry.dtheta_rad)


def _order(wire: RobotOrderWire) -> RobotOrder:
    place = None if wire.x_m is None or wire.y_m is None else (wire.x_m, wire.y_m)
    methods = Methods(wire.explore, wire.coordinate, wire.communication)
    area = tuple((x, y) for x, y in wire.area_m)
    return RobotOrder(wire.order_id, wire.kind, wire.by, place, methods, area)


def _tag(wire: TagSightingWire) -> TagSighting:
    sensors = wire.sensors
    return TagSighting(
        tag_id=wire.tag_id,
        memory=base64.b64decode(wire.memory),
        range_m=wire.range_m,
        bearing_rad=wire.bearing_rad,
        rssi_dbm=wire.rssi_dbm,
        antenna=wire.antenna,
        sensors=None
        if sensors is None
        else NodeSensors(sensors.temperature_c, sensors.pressure_hpa, sensors.tilt_rad),
    )


def _imu(wire: ImuWire) -> ImuReading:
    return ImuReading(wire.yaw_rad, wire.roll_rad, wire.pitch_rad)


def _scan(wire: ScanWire) -> LaserScan:
    ranges = np.array([inf if value is None else value for value in wire.ranges_m], dtype=np.float32)
    return LaserScan(ranges, wire.angle_min_rad, wire.angle_increment_rad, wire.range_max_m)
