"""When a node's readings are worth an alert: thresholds with hysteresis, counted in readings.

Readings are counted, not timed, so that a mission that is played fast is judged like a live one. Two in a row
raise an alert: a single one may be garbled. Ten calm ones in a row end it: of two nodes that bear one id, the
cool one must not silence the hot one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, radians

from db.records import AlertKind, NodeRecord, Severity

_RAISES, _ENDS = 2, 10
_USUAL_READINGS = 300  # over which the usual pressure is averaged: about five minutes


@dataclass(frozen=True, slots=True)
class Rule:
    """An alert is raised at ``raise_at`` and over below ``end_below``, both of ``level``."""

    kind: AlertKind
    severity: Severity
    raise_at: float
    end_below: float

    def level(self, node: NodeRecord) -> float | None:
        """Return what is compared, None where the node does not measure it."""
        if self.kind == "hot":
            return node.temperature_c
        if self.kind == "tilted":
            return node.tilt_rad
        if node.pressure_hpa is None or node.usual_pressure_hpa is None:
            return None
        return abs(node.pressure_hpa - node.usual_pressure_hpa)

    def raised(self, node: NodeRecord) -> str:
        """Return what to say when it is raised."""
        if self.kind == "hot":
            return f"It is hot at node {node.tag_id}: {node.temperature_c:.0f} °C."
        if self.kind == "tilted":
            return f"Node {node.tag_id} has been knocked over: it leans by {_degrees(node)} degrees."
        change = (node.pressure_hpa or 0.0) - (node.usual_pressure_hpa or 0.0)
        way = "rose" if change > 0.0 else "fell"
        return f"The pressure at node {node.tag_id} {way} by {abs(change):.1f} hPa."

    def over(self, node: NodeRecord) -> str:
        """Return what to say when it is over."""
        if self.kind == "hot":
            return f"Node {node.tag_id} has cooled down to {node.temperature_c:.0f} °C."
        if self.kind == "tilted":
            return f"Node {node.tag_id} stands again."
        return f"The pressure at node {node.tag_id} is steady again."


RULES = (
    Rule("hot", "alarm", raise_at=60.0, end_below=50.0),  # degrees Celsius; people cannot stay above 60
    Rule("tilted", "warning", raise_at=radians(35.0), end_below=radians(20.0)),
    Rule("pressure", "warning", raise_at=3.0, end_below=1.5),  # hPa from the usual; weather is slower
)


@dataclass(slots=True)
class Watch:
    """Watches one node under one rule."""

    rule: Rule
    active: bool = False
    _against: int = 0  # readings in a row that speak against the state

    def take(self, node: NodeRecord) -> bool:
        """Take a reading; say whether the state has changed."""
        level = self.rule.level(node)
        if level is None:
            return False
        against = level < self.rule.end_below if self.active else level >= self.rule.raise_at
        self._against = self._against + 1 if against else 0
        if self._against < (_ENDS if self.active else _RAISES):
            return False
        self.active, self._against = not self.active, 0
        return True


def with_usual_pressure(node: NodeRecord, before: float | None) -> NodeRecord:
    """Return the node with its usual pressure, which follows a lasting change in some minutes."""
    if node.pressure_hpa is None or before is None:
        return replace(node, usual_pressure_hpa=before if node.pressure_hpa is None else node.pressure_hpa)
    return replace(node, usual_pressure_hpa=before + (node.pressure_hpa - before) / _USUAL_READINGS)


def _degrees(node: NodeRecord) -> int:
    return round(degrees(node.tilt_rad or 0.0))
