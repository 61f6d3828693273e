"""What the store hands out of victims: what the team measured, and what people said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from db.records import PointRecord

VictimStatus = Literal["suspected", "confirmed", "reached", "extricated", "dismissed"]
Triage = Literal["unknown", "minor", "delayed", "immediate", "deceased"]
_CROSSED_OUT = 20  # so many earlier counts of a kind are kept, the latest


@dataclass(frozen=True, slots=True)
class StartRecord:
    """What a person found at a victim, step by step of START; None is not found out yet."""

    walks: bool | None = None
    breaths_per_min: int | None = None  # 0: does not breathe
    breathes_after_airway: bool | None = None  # once the airway is open
    pulse: bool | None = None  # radial pulse, or capillaries refill within 2 s
    obeys: bool | None = None  # simple commands

    @property
    def triage(self) -> Triage:
        """The category of START (adult); "unknown" until the answers given decide it."""
        if self.walks:
            return "minor"
        if self.walks is None or self.breaths_per_min is None:
            return "unknown"
        if self.breaths_per_min == 0:
            after = self.breathes_after_airway
            return "unknown" if after is None else "immediate" if after else "deceased"
        if self.breaths_per_min > 30 or self.pulse is False:
            return "immediate"
        if self.pulse is None:
            return "unknown"
        return "unknown" if self.obeys is None else "delayed" if self.obeys else "immediate"


@dataclass(frozen=True, slots=True)
class SaidRecord:
    """What people said about a victim; robots never change it.

    ``live`` and ``dead`` are how many are still there (INSARAG L-n, D-n), None while nobody has said;
    ``live_before`` and ``dead_before`` the counts that stood there before, the oldest first: crossed out.
    ``place_m``: where a person put it, in the world frame; ``merged_into``: the victim that it really is.
    ``tag_id``: the tag it was reported at, with which it moves.
    """

    status: VictimStatus = "suspected"
    note: str = ""
    team: str = ""
    live: int | None = None
    dead: int | None = None
    live_before: tuple[int, ...] = ()
    dead_before: tuple[int, ...] = ()
    start: StartRecord = field(default_factory=StartRecord)
    place_m: tuple[float, float] | None = None
    merged_into: str | None = None
    tag_id: str | None = None
    by: str = ""
    changed_unix_s: float | None = None

    def value(self) -> dict[str, Any]:
        """Return it as plain values, as it is stored and goes over the wire."""
        return asdict(self)

    @classmethod
    def of(cls, value: dict[str, Any]) -> SaidRecord:
        """Return what ``value`` was made of."""
        place = value.get("place_m")
        told = {
            "start": StartRecord(**value.get("start", {})),
            "place_m": None if place is None else tuple(place),
            "live_before": tuple(value.get("live_before", ())),
            "dead_before": tuple(value.get("dead_before", ())),
        }
        return cls(**{**value, **told})

    def crossed_out(self, words: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
        """Return which counts stand crossed out once ``words`` are said: none where a count is taken back."""
        found = {}
        for name in ("live", "dead"):
            old, new = getattr(self, name), words.get(name, getattr(self, name))
            if new != old:
                stood = getattr(self, f"{name}_before")
                found[f"{name}_before"] = (
                    () if new is None else (*stood, old)[-_CROSSED_OUT:] if old else stood
                )
        return found


@dataclass(frozen=True, slots=True)
class VictimRecord:
    """A victim: what the team measured, and what people said about it."""

    victim_id: str
    place: PointRecord
    confidence: float
    sightings: int
    robots: tuple[str, ...]
    first_seen_s: float
    last_seen_s: float
    said: SaidRecord = field(default_factory=SaidRecord)
