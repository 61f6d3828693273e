"""A person who walks by what a phone says: an arrow, a sentence, the next tag; never told where they are.

The errors of people on foot: steps of another length than they think, a compass that is off in every
building's steel, drift, stops, and now and then a start in a wrong direction that is noticed after a few
metres. They see walls some metres ahead and go round them, read a tag within arm's reach, and notice a victim
two metres off. Where a tag is not where it should be they look for it, in circles that widen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, hypot, inf, pi, radians, sin

import numpy as np

from robots.sim.rays import cast, in_sight
from robots.sim.starts import Victim
from robots.sim.tags import TagField
from robots.sim.walker_words import Piece, pieces_of
from robots.sim.world import GLASS, SOLID, World

TICK_S = 0.2
ARM_M = 0.8  # a tag so near is read
NOTICES_M = 2.0  # a victim so near and in sight is heard or felt for
THERE_M = 0.6
_STRIDE_M = 0.7
_SPEED_MPS = 0.7  # in smoke, with a hand at the wall
_SHOULDER_M = 0.22
_SIGHT_M = 3.0
_SEARCH_M = 5.0  # from where a tag should be
_TRUSTED_M = 6.0  # what a phone knows no better is looked for without it
_HEADINGS = np.linspace(-pi, pi, 48, endpoint=False)
_STUCK_TICKS = 25
_TOUCH_AGAIN_TICKS = 50  # who passes between two tags does not touch them in turns


@dataclass(frozen=True, slots=True)
class Advice:
    """What the phone shows at a tag: an arrow, a sentence, and the next tag (None: the way ends there).

    ``away_m``: where the next stop lies on its plan, north and west of the tag.
    """

    bearing_deg: float
    text: str
    to_tag: str | None
    away_m: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Fix:
    """Where the phone says it is by the nodes it hears, north and west of the tag read last, and how well."""

    away_m: tuple[float, float]
    right_to_m: float


Phone = Callable[[str], Advice | None]  # asked at a tag; None: it leads nowhere
Listen = Callable[[str, float, float, int], Fix | None]  # at a place, so many steps from a tag


@dataclass(frozen=True, slots=True)
class Gait:
    """How a person errs, as standard deviations: of one step, and of all steps or at one tag.

    ``stops`` and ``astray``: how likely they stop within a second, and set out wrongly from a tag.
    """

    scale: float = 0.06
    stride: float = 0.1
    compass_rad: float = radians(7.0)
    drift_rad: float = radians(5.0)
    stops: float = 0.02
    astray: float = 0.15


class Walker:
    """Somebody at a tag, being led. ``advance`` lets them walk for a tick."""

    def __init__(
        self,
        world: World,
        tags: TagField,
        victims: tuple[Victim, ...],
        phone: Phone,
        start_m: tuple[float, float],
        seed: int,
        gait: Gait | None = None,
        listen: Listen | None = None,
    ) -> None:
        self._world, self._tags, self._victims, self._phone = world, tags, victims, phone
        self._listen, self._since_m = listen, 0.0
        self._gait = gait or Gait()
        self._rng = np.random.default_rng([seed, 90])
        self.x_m, self.y_m = start_m
        self._scale = 1.0 + self._gait.scale * float(self._rng.normal())
        self._off_rad = 0.0  # of the compass here; another at every tag
        self._reckoned = (0.0, 0.0)  # metres north and west of the last tag, as they think
        self._heading = 0.0
        self._is_last_leg = False
        self._ticks = 0
        self._touched: dict[str, int] = {}  # tags, and when
        self.last_tag: str | None = None
        self.read: list[str] = []  # the tags in the order in which they were read
        self.walked_m = 0.0
        self.arrived = False
        self._life = self._live()

    @property
    def reckoned_m(self) -> tuple[float, float]:
        """Where they think they are: metres north and west of the tag read last, by their compass."""
        return self._reckoned

    def advance(self) -> bool:
        """Walk for a tick; return whether there is more to do."""
        self._ticks += 1
        return next(self._life, None) is not None

    def _live(self) -> Iterator[bool]:
        """Go from tag to tag until the victim is reached; True after every tick."""
        yield from self._search()  # for the tag they begin at
        while self.last_tag is not None:
            tag = self.last_tag
            advice = self._phone(tag)
            if advice is None:
                return
            self._is_last_leg = advice.to_tag is None
            yield from self._follow(advice, tag)
            if self.arrived:
                return
            if self.last_tag == tag:
                yield from self._look_at_plan(advice)
            if self.last_tag == tag and not self.arrived:
                yield from self._search()
            if self.last_tag == tag and not self.arrived:
                return  # lost: they stay and call

    def _follow(self, advice: Advice, tag: str) -> Iterator[bool]:
        bearing = -radians(advice.bearing_deg)
        if self._rng.random() < self._gait.astray:
            aside = float(self._rng.choice([-1.0, 1.0]) * self._rng.uniform(pi / 3, 2 * pi / 3))
            yield from self._go(bearing + aside, float(self._rng.uniform(1.5, 3.0)))
            yield from self._go_to((0.0, 0.0))
        for piece in pieces_of(advice.text):
            if piece.turn is not None:
                bearing = self._opening(bearing, piece)
            yield from self._go(bearing, piece.metres)
            if self.arrived or self.last_tag != tag:
                return

    def _look_at_plan(self, advice: Advice) -> Iterator[bool]:
        """Not where the next stop should be: go on from where the phone says that they are, if it knows."""
        fix, away = None, advice.away_m
        if self._listen is not None and away is not None and self.last_tag is not None:
            fix = self._listen(self.last_tag, self.x_m, self.y_m, round(self._since_m / _STRIDE_M))
        if fix is None or away is None or fix.right_to_m > _TRUSTED_M:
            return
        self._reckoned = fix.away_m
        yield from self._go_to(away)

    def _opening(self, bearing: float, piece: Piece) -> float:
        """Return the most open direction on the side of a turn: words do not say by how much."""
        if piece.turn == "round":
            return bearing + pi
        side = 1.0 if piece.turn == "left" else -1.0
        turns = np.radians(np.arange(40.0, 145.0, 5.0))
        room = np.minimum(self._look(bearing + side * turns, piece.metres), piece.metres)
        return bearing + side * float(turns[(room - 0.3 * np.abs(turns - pi / 2)).argmax()])

    def _go(self, bearing: float, far_m: float) -> Iterator[bool]:
        north, west = self._reckoned
        yield from self._go_to((north + far_m * cos(bearing), west + far_m * sin(bearing)))

    def _go_to(self, goal: tuple[float, float], patience: int = _STUCK_TICKS) -> Iterator[bool]:
        """Walk to a place as they reckon it; give up where it comes no nearer, stop at a new tag."""
        tag, nearest, waited = self.last_tag, inf, 0
        while waited < patience:
            north, west = goal[0] - self._reckoned[0], goal[1] - self._reckoned[1]
            far = hypot(north, west)
            if far < 0.15:
                return
            nearest, waited = (far, 0) if far < nearest - 0.05 else (nearest, waited + 1)
            self._step(float(np.arctan2(west, north)), far)
            yield True
            yield from self._pause()
            yield from self._meet()
            if self.arrived or self.last_tag != tag:
                return

    def _step(self, bearing: float, far: float) -> None:
        """Make a step towards a bearing, round what is in the way."""
        room = self._look(bearing + _HEADINGS, 1.0)
        turn = np.abs(_HEADINGS) + 0.25 * np.abs(np.angle(np.exp(1j * (bearing + _HEADINGS - self._heading))))
        ways = np.where(room >= min(0.5, far), turn, inf)
        if not np.isfinite(ways).any():
            ways = turn - room
        heading = float(bearing + _HEADINGS[int(ways.argmin())])
        stride = min(_SPEED_MPS * TICK_S, far)
        self._heading = heading
        gait, draw = self._gait, self._rng.normal
        truly = stride * max(0.0, self._scale + gait.stride * float(draw()))
        along = heading + self._off_rad + gait.drift_rad * float(draw())
        if (
            cast(
                self._world, self.x_m, self.y_m, np.array([along]), truly + _SHOULDER_M, stops=SOLID, loses=0
            )[0]
            < inf
        ):
            return  # a wall: they notice that they did not move
        self.x_m += truly * cos(along)
        self.y_m += truly * sin(along)
        self.walked_m += truly
        self._since_m += truly
        north, west = self._reckoned
        self._reckoned = (north + stride * cos(heading), west + stride * sin(heading))

    def _look(self, bearings: np.ndarray, far_m: float) -> np.ndarray:
        """Return how far they could walk along bearings of their compass, (n,), at most ``far_m``."""
        along = np.asarray(bearings, float) + self._off_rad
        room = np.full(len(along), min(far_m, _SIGHT_M))
        for aside in (-_SHOULDER_M, 0.0, _SHOULDER_M):
            x, y = self.x_m - aside * np.sin(along), self.y_m + aside * np.cos(along)
            for k, angle in enumerate(along):
                seen = cast(
                    self._world,
                    x[k],
                    y[k],
                    angle[None],
                    float(room[k]),
                    stops=SOLID,
                    loses=0,
                    smoke_depth_m=inf,
                )
                room[k] = min(room[k], float(seen[0]))
        return room

    def _pause(self) -> Iterator[bool]:
        if self._rng.random() < self._gait.stops * TICK_S:
            for _ in range(int(self._rng.uniform(10, 40))):
                yield True

    def _meet(self) -> Iterator[bool]:
        """Read a tag within reach; on the last leg, go to a victim that is noticed."""
        here = self.x_m, self.y_m
        for index in self._in_reach():
            tag_id = self._tags.tag(index).tag_id
            if self._ticks - self._touched.get(tag_id, -_TOUCH_AGAIN_TICKS) < _TOUCH_AGAIN_TICKS:
                continue
            if tag_id != self.last_tag and in_sight(self._world, here, tuple(self._tags.places_m[index])):
                self._read(tag_id, index)
                return
        if not self._is_last_leg:
            return
        for victim in self._victims:
            place = victim.x_m, victim.y_m
            if hypot(place[0] - here[0], place[1] - here[1]) < NOTICES_M and in_sight(
                self._world, here, place, GLASS | 1
            ):
                yield from self._join(victim)
                return

    def _in_reach(self) -> list[int]:
        places = self._tags.places_m
        far = np.hypot(places[:, 0] - self.x_m, places[:, 1] - self.y_m)
        return [int(k) for k in np.argsort(far) if far[k] <= ARM_M]

    def _read(self, tag_id: str, index: int) -> None:
        """Touch a tag: from now on they reckon from where it lies before them."""
        x, y = self._tags.places_m[index]
        self._off_rad = self._gait.compass_rad * float(self._rng.normal())
        c, s = cos(-self._off_rad), sin(-self._off_rad)
        dx, dy = self.x_m - x, self.y_m - y
        self._reckoned = (c * dx - s * dy, s * dx + c * dy)
        self.last_tag, self._since_m = tag_id, 0.0
        self._touched[tag_id] = self._ticks
        self.read.append(tag_id)

    def _join(self, victim: Victim) -> Iterator[bool]:
        for _ in range(100):
            dx, dy = victim.x_m - self.x_m, victim.y_m - self.y_m
            if hypot(dx, dy) < THERE_M:
                self.arrived = True
                return
            self._step(float(np.arctan2(dy, dx)) - self._off_rad, hypot(dx, dy))
            yield True

    def _search(self) -> Iterator[bool]:
        """Look for a tag or the victim round here, in circles that widen."""
        tag, (north, west) = self.last_tag, self._reckoned
        for ring in np.arange(1.0, _SEARCH_M + 0.1, 1.0):
            yield from self._meet()
            count = int(2 * pi * ring / 1.0)
            for angle in 2 * pi * np.arange(count) / count:
                if self.arrived or self.last_tag != tag:
                    return
                yield from self._go_to((north + ring * cos(angle), west + ring * sin(angle)), 8)
