"""Things of one kind in the scene, each drawn anew only when its looks are others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import viser

Looks = TypeVar("Looks")


class Kept(Generic[Looks]):
    """What is drawn below one name of the scene, by id. Names are ours: an id could hold a slash."""

    def __init__(self, scene: viser.SceneApi, name: str, draw: Callable[[str, Looks], None]) -> None:
        self._scene = scene
        self._name = name
        self._draw = draw
        self._names: dict[str, str] = {}
        self._drawn: dict[str, Looks] = {}
        self._count = 0

    def show(self, wanted: Mapping[str, Looks]) -> None:
        """Bring the scene to the looks that are wanted, by id."""
        for gone in self._drawn.keys() - wanted.keys():
            del self._drawn[gone]
            self._scene.remove_by_name(self._names.pop(gone))
        for thing_id, looks in wanted.items():
            if self._drawn.get(thing_id) == looks:
                continue
            if thing_id in self._names:
                self._scene.remove_by_name(self._names[thing_id])
            else:
                self._count += 1
                self._names[thing_id] = f"{self._name}/{self._count}"
            self._draw(self._names[thing_id], looks)
            self._drawn[thing_id] = looks
