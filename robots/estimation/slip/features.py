"""What the slip detector looks at: differences of the four wheels' velocities, commands and gyro, over 0.3 s.

All in m/s and rad/s, so that they do not depend on how often a robot observes. A robot that turns right is
looked at in a mirror, and one that drives backwards from its rear, so that four situations count as one.
Where the encoders are noisy (``slip_noise``), what may be noise is scaled down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robots.estimation.slip.noise import WalkNoise

WINDOW_S = 0.3
# half the track a square of four wheels seems to have when it scrubs round on the spot: with wheels half a
# track b beside and half a base a before the middle, friction balances at (a^2 + b^2) / b
_SCRUB_M = 0.31
_EXACT_MPS = 0.02  # an error of a velocity that is no matter

BASIC_FEATURES = ("left_mps", "right_mps", "front_mps", "rear_mps")
EXTENDED_FEATURES = (
    *(f"window_{name}" for name in BASIC_FEATURES),
    "window_range_mps",  # how much a difference changed within the window, at most
    "speed_mps",
    "gain_mps",  # speed now beyond that of the window
    "command_mps",
    "command_change_mps",  # from that of the window
    "command_beyond_speed_mps",  # both of the window
    "fastest_beyond_command_mps",  # of the wheels, each less what the turn makes of it
    "slowest_beyond_command_mps",
    "wheel_turn_mps",  # half of right side less left side
    "yaw_radps",
    "command_radps",
    "command_beyond_yaw_radps",
    "wheel_turn_beyond_yaw_mps",
)
Four = tuple[float, float, float, float]  # front left, front right, rear left, rear right


def differences(wheels: Four) -> Four:
    """Return the velocity differences Left, Right, Front, Rear of Kleiner 2006 from four velocities."""
    front_left, front_right, rear_left, rear_right = wheels
    return front_left - rear_left, front_right - rear_right, front_left - front_right, rear_left - rear_right


def canonical(wheels: Four) -> Four:
    """Return the wheels of the same motion seen as a left turn and as driving ahead.

    Seen from the rear of a robot that backs up, what was behind on its left is ahead on its right.
    """
    front_left, front_right, rear_left, rear_right = wheels
    if front_left + front_right + rear_left + rear_right < 0.0:
        front_left, front_right, rear_left, rear_right = -rear_right, -rear_left, -front_right, -front_left
    if front_left + rear_left > front_right + rear_right:
        front_left, front_right, rear_left, rear_right = front_right, front_left, rear_right, rear_left
    return front_left, front_right, rear_left, rear_right


@dataclass(frozen=True, slots=True)
class Noise:
    """Random walk of the wheels' differences and of their mean, in metres per square root of a metre."""

    differences: WalkNoise
    mean: WalkNoise


def _trust(noise: WalkNoise, rolled_m: float, time_s: float) -> float:
    """Return what a velocity counts: 1 where it is about exact, less where it errs by more than that."""
    return _EXACT_MPS / max(_EXACT_MPS, noise.velocity_sd_mps(rolled_m, time_s))


@dataclass(frozen=True, slots=True)
class Moment:
    """One observation: ``since_s`` its interval, ``wheels`` velocities (m/s) in it, heading and command.

    ``yaw_rad`` is unwrapped; ``command`` is speed and turn rate that were in force. Absent is None.
    """

    stamp_s: float
    since_s: float
    wheels: Four
    yaw_rad: float | None
    command: tuple[float, float] | None

    @property
    def rolled_m(self) -> float:
        """Mean of what the four wheels rolled, whichever way."""
        return sum(map(abs, self.wheels)) / 4.0 * self.since_s


def basic_features(moment: Moment, noise: Noise) -> list[float]:
    """Return the values of ``BASIC_FEATURES`` at one moment."""
    trust = _trust(noise.differences, moment.rolled_m, moment.since_s)
    return [trust * value for value in differences(canonical(moment.wheels))]


def extended_features(moments: Sequence[Moment], since: Moment, noise: Noise) -> list[float] | None:
    """Return the values of ``EXTENDED_FEATURES`` over moments, oldest first, that follow on ``since``.

    None where gyro or command are missing in one of them.
    """
    now = moments[-1]
    time_s = sum(moment.since_s for moment in moments)
    wheels = [0.0, 0.0, 0.0, 0.0]
    command_mps = command_radps = 0.0
    for moment in moments:
        if moment.command is None:
            return None
        share = moment.since_s / time_s
        for k in range(4):
            wheels[k] += share * moment.wheels[k]
        command_mps += share * moment.command[0]
        command_radps += share * moment.command[1]
    if now.command is None or now.yaw_rad is None or since.yaw_rad is None:
        return None
    ahead = 1.0 if sum(wheels) >= 0.0 else -1.0
    left = 1.0 if wheels[0] + wheels[2] <= wheels[1] + wheels[3] else -1.0
    seen = canonical((wheels[0], wheels[1], wheels[2], wheels[3]))
    by_time = zip(*(differences(moment.wheels) for moment in moments), strict=True)
    speed = sum(seen) / 4.0
    wheel_turn = (seen[1] + seen[3] - seen[0] - seen[2]) / 2.0
    command_mps *= ahead
    command_radps *= left
    straight = [seen[k] - (wheel_turn if k % 2 else -wheel_turn) for k in range(4)]
    rolled_m = sum(moment.rolled_m for moment in moments)
    apart = _trust(noise.differences, rolled_m, time_s)
    mean = _trust(noise.mean, rolled_m, time_s)
    mean_now = _trust(noise.mean, now.rolled_m, now.since_s)
    apart_now = _trust(noise.differences, now.rolled_m, now.since_s)
    yaw_radps = left * (now.yaw_rad - since.yaw_rad) / time_s
    return [
        *(apart * value for value in differences(seen)),
        apart_now * max(max(values) - min(values) for values in by_time),
        speed,
        mean_now * (ahead * sum(now.wheels) / 4.0 - speed),
        command_mps,
        ahead * now.command[0] - command_mps,
        mean * (command_mps - speed),
        mean * (max(straight) - command_mps),
        mean * (min(straight) - command_mps),
        wheel_turn,
        yaw_radps,
        command_radps,
        command_radps - yaw_radps,
        apart * (wheel_turn - _SCRUB_M * yaw_radps),
    ]
