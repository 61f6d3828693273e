"""Observations and commands as the robot API's JSON objects and back, exactly.

JSON keeps doubles bit for bit. Ranges are float32 in steps of a millimetre: they travel as short decimals
that name the same float32; a far reading travels as null and comes back as the scan's maximum range.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from robots.orders import Methods, RobotOrder
from robots.se2 import Pose2
from robots.sim.sensors import far_reading
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

Json = dict[str, Any]

_KINDS: dict[type[Any], str] = {
    WheelEncoders: "wheels",
    DistanceTurn: "distance_turn",
    Displacement: "displacement",
}
_ODOMETRY: dict[str, type[Any]] = {name: cls for cls, name in _KINDS.items()}


def observation_to_wire(observation: Observation) -> Json:
    """Return the JSON object of an observation; what is absent or empty is left out."""
    wire: Json = {"seq": observation.seq, "stamp_s": observation.stamp_s}
    if observation.odometry is not None:
        wire["odometry"] = {"kind": _KINDS[type(observation.odometry)], **_fields(observation.odometry)}
    if observation.imu is not None:
        wire["imu"] = _fields(observation.imu)
    if observation.scan is not None:
        wire["scan"] = _scan_to_wire(observation.scan)
    if observation.beams:
        wire["beams"] = [_fields(beam) for beam in observation.beams]
    if observation.tag_sightings:
        wire["tag_sightings"] = [_tag_to_wire(sighting) for sighting in observation.tag_sightings]
    if observation.robot_sightings:
        wire["robot_sightings"] = [_fields(sighting) for sighting in observation.robot_sightings]
    if observation.heat:
        wire["heat"] = [_fields(reading) for reading in observation.heat]
    if observation.battery is not None:
        wire["battery"] = observation.battery
    if observation.tags_left is not None:
        wire["tags_left"] = observation.tags_left
    if observation.bumper:
        wire["bumper"] = True
    if observation.held:
        wire["held"] = True
    if observation.orders:
        wire["orders"] = [order_to_wire(order) for order in observation.orders]
    if observation.heard:
        wire["heard"] = [_text(message) for message in observation.heard]
    return wire


def observation_from_wire(wire: Json) -> Observation:
    """Return the observation of a JSON object that ``observation_to_wire`` made."""
    odometry: Odometry | None = None
    if "odometry" in wire:
        fields = dict(wire["odometry"])
        odometry = _ODOMETRY[fields.pop("kind")](**fields)
    return Observation(
        seq=wire["seq"],
        stamp_s=wire["stamp_s"],
        odometry=odometry,
        imu=ImuReading(**wire["imu"]) if "imu" in wire else None,
        scan=_scan_from_wire(wire["scan"]) if "scan" in wire else None,
        beams=tuple(RangeReading(**beam) for beam in wire.get("beams", ())),
        tag_sightings=tuple(_tag_from_wire(item) for item in wire.get("tag_sightings", ())),
        robot_sightings=tuple(RobotSighting(**item) for item in wire.get("robot_sightings", ())),
        heat=tuple(HeatReading(**reading) for reading in wire.get("heat", ())),
        battery=wire.get("battery"),
        tags_left=wire.get("tags_left"),
        bumper=wire.get("bumper", False),
        held=wire.get("held", False),
        orders=tuple(order_from_wire(order) for order in wire.get("orders", ())),
        heard=tuple(base64.b64decode(message) for message in wire.get("heard", ())),
    )


def command_to_wire(command: Command) -> Json:
    """Return the JSON object of a command."""
    return {
        "linear_mps": command.linear_mps,
        "angular_radps": command.angular_radps,
        "drop_tag": command.drop_tag,
        "writes": [{"tag_id": write.tag_id, "memory": _text(write.memory)} for write in command.writes],
        "say": None if command.say is None else _text(command.say),
    }


def command_from_wire(wire: Json) -> Command:
    """Return the command of a reply's JSON object."""
    return Command(
        linear_mps=float(wire["linear_mps"]),
        angular_radps=float(wire["angular_radps"]),
        drop_tag=bool(wire["drop_tag"]),
        writes=tuple(TagWrite(item["tag_id"], base64.b64decode(item["memory"])) for item in wire["writes"]),
        say=None if wire.get("say") is None else base64.b64decode(wire["say"]),
    )


def order_to_wire(order: RobotOrder) -> Json:
    """Return the JSON object of an operator's order."""
    x_m, y_m = (None, None) if order.place_m is None else order.place_m
    wire: Json = {"order_id": order.order_id, "kind": order.kind, "by": order.by, **_fields(order.methods)}
    return {**wire, "x_m": x_m, "y_m": y_m, "area_m": [list(corner) for corner in order.area_m]}


def order_from_wire(wire: Json) -> RobotOrder:
    """Return an operator's order of a reply's JSON object."""
    place = None if wire["x_m"] is None else (float(wire["x_m"]), float(wire["y_m"]))
    methods = Methods(*(wire[name] for name in Methods.__slots__))
    area = tuple((float(x), float(y)) for x, y in wire.get("area_m", ()))
    return RobotOrder(wire["order_id"], wire["kind"], wire["by"], place, methods, area)


def pose_to_wire(pose: Pose2) -> Json:
    """Return the JSON object of a pose."""
    return {"x_m": pose.x, "y_m": pose.y, "yaw_rad": pose.theta}


def _fields(value: Any) -> Json:
    return {name: getattr(value, name) for name in type(value).__slots__}


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _tag_to_wire(sighting: TagSighting) -> Json:
    wire: Json = {"tag_id": sighting.tag_id, "memory": _text(sighting.memory)}
    for name in ("range_m", "bearing_rad", "rssi_dbm", "antenna"):
        if (value := getattr(sighting, name)) is not None:
            wire[name] = value
    if sighting.sensors is not None:
        wire["sensors"] = _fields(sighting.sensors)
    return wire


def _tag_from_wire(wire: Json) -> TagSighting:
    return TagSighting(
        tag_id=wire["tag_id"],
        memory=base64.b64decode(wire["memory"]),
        range_m=wire.get("range_m"),
        bearing_rad=wire.get("bearing_rad"),
        rssi_dbm=wire.get("rssi_dbm"),
        antenna=wire.get("antenna"),
        sensors=NodeSensors(**wire["sensors"]) if "sensors" in wire else None,
    )


def _scan_to_wire(scan: LaserScan) -> Json:
    exact = scan.ranges_m.astype(np.float64)
    short = np.round(exact, 3)
    values = np.where(short.astype(np.float32) == scan.ranges_m, short, exact).tolist()
    far = ~np.isfinite(exact) | (exact >= scan.range_max_m)
    return {
        "ranges_m": [None if gone else value for value, gone in zip(values, far.tolist(), strict=True)],
        "angle_min_rad": scan.angle_min_rad,
        "angle_increment_rad": scan.angle_increment_rad,
        "range_max_m": scan.range_max_m,
    }


def _scan_from_wire(wire: Json) -> LaserScan:
    far = far_reading(wire["range_max_m"])
    ranges = np.array([far if value is None else value for value in wire["ranges_m"]], dtype=np.float32)
    return LaserScan(ranges, wire["angle_min_rad"], wire["angle_increment_rad"], wire["range_max_m"])
