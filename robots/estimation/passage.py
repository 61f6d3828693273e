"""What passing tags changed in a robot's map."""

from __future__ import annotations

from dataclasses import dataclass

from robots.types import TagSighting


@dataclass(frozen=True, slots=True)
class Passage:
    """What passing tags changed.

    ``read``: tags that came within reach of writing just now; ``anchored``: the graph has a new pose vertex;
    ``moved``: what was mapped before lies elsewhere now; ``changed``: something was added to the graph.
    """

    read: tuple[TagSighting, ...] = ()
    anchored: bool = False
    moved: bool = False
    changed: bool = False
