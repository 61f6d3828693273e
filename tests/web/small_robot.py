"""A robot without faults for tests in the browser."""

from __future__ import annotations

import threading
from math import atan2, cos, hypot, inf, pi, sin
from typing import Any

import httpx

MISSION = "drill"


class SmallRobot:
    """A robot without faults in a rectangular room, driven by the server's commands through the API."""

    ROOM = (-4.0, -3.0, 8.0, 5.0)  # smallest x and y, largest x and y, in metres
    REACH_M = 2.5  # of the laser: shorter than the room, so that the robot has to drive to see it
    VICTIM = (2.5, 2.0)
    PERIOD_S = 0.2
    BEAMS = 181

    def __init__(self, client: httpx.Client, robot_id: str, mission: str = MISSION) -> None:
        self.client = client
        at = f"/api/v1/missions/{mission}/robots"
        self.address = f"{at}/{robot_id}/observations"
        registration = {
            "robot_id": robot_id,
            "agent": "server",
            "silence": {"after_s": 2.0, "policy": "hold"},
        }
        client.post(at, json=registration).raise_for_status()
        self.x = self.y = self.yaw = 0.0
        self.seq = 0
        self.linear = self.angular = 0.0
        self.over = threading.Event()
        self.failure: Exception | None = None
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def stop(self) -> None:
        self.over.set()
        self.thread.join(timeout=60)

    def _run(self) -> None:
        try:
            while not self.over.wait(self.PERIOD_S):
                reply = self.client.post(
                    self.address, json={"observations": [self._observation()]}, timeout=60
                )
                reply.raise_for_status()
                command = reply.json()["command"]
                self.linear, self.angular = command["linear_mps"], command["angular_radps"]
        except httpx.HTTPError as error:
            if not self.over.is_set():
                self.failure = error

    def _observation(self) -> dict[str, Any]:
        turn = self.angular * self.PERIOD_S
        distance = min(self.linear * self.PERIOD_S, self._range(self.yaw + turn) - 0.3)
        self.yaw = atan2(sin(self.yaw + turn), cos(self.yaw + turn))
        self.x += distance * cos(self.yaw)
        self.y += distance * sin(self.yaw)
        bearings = [-pi / 2 + i * pi / (self.BEAMS - 1) for i in range(self.BEAMS)]
        dx, dy = self.VICTIM[0] - self.x, self.VICTIM[1] - self.y
        observation = {
            "seq": self.seq,
            "stamp_s": self.seq * self.PERIOD_S,
            "odometry": {"kind": "distance_turn", "distance_m": distance, "turn_rad": turn},
            "imu": {"yaw_rad": self.yaw, "roll_rad": 0.0, "pitch_rad": 0.0},
            "scan": {
                "ranges_m": [min(self._range(self.yaw + bearing), self.REACH_M) for bearing in bearings],
                "angle_min_rad": -pi / 2,
                "angle_increment_rad": pi / (self.BEAMS - 1),
                "range_max_m": self.REACH_M,
            },
            "heat": [
                {
                    "bearing_rad": atan2(dy, dx) - self.yaw,
                    "range_m": hypot(dx, dy),
                    "confidence": 0.9,
                }
            ],
            "battery": 0.8,
            "tags_left": 100,
        }
        self.seq += 1
        return observation

    def _range(self, direction: float) -> float:
        """Distance to the wall of the room in a direction of the world, in metres."""
        low_x, low_y, high_x, high_y = self.ROOM
        c, s = cos(direction), sin(direction)
        to_x = ((high_x if c > 0 else low_x) - self.x) / c if abs(c) > 1e-9 else inf
        to_y = ((high_y if s > 0 else low_y) - self.y) / s if abs(s) > 1e-9 else inf
        return min(to_x, to_y)
