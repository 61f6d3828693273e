"""Annotations: what people write on the map."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from db.records import AnnotationRecord
from db.store import Store
from server.board import Board
from server.errors import unknown
from server.sharing import annotation_value


class Annotations:
    """The annotations by id, oldest first."""

    def __init__(self, store: Store, mission_id: str, board: Board) -> None:
        self._store = store
        self._mission_id = mission_id
        self._board = board
        self._annotations: dict[str, AnnotationRecord] = {}

    async def restore(self) -> None:
        """Bring the annotations back from the database."""
        for annotation in await self._store.findings.annotations_of(self._mission_id):
            self._keep(annotation)

    def all(self) -> list[AnnotationRecord]:
        """Return every annotation, oldest first."""
        return list(self._annotations.values())

    def value(self, annotation_id: str) -> dict[str, Any] | None:
        """Return an annotation as it goes over the wire; None where there is none."""
        known = self._annotations.get(annotation_id)
        return None if known is None else annotation_value(known)

    async def put(self, annotation: AnnotationRecord) -> AnnotationRecord:
        """Write an annotation and return it as it stands.

        The same id replaces the earlier one and keeps when that was created; the same words change nothing.
        """
        known = self._annotations.get(annotation.annotation_id)
        if known is not None:
            annotation = replace(annotation, created_unix_s=known.created_unix_s)
            if replace(annotation, changed_unix_s=known.changed_unix_s) == known:
                return known
        await self._store.findings.record_annotation(self._mission_id, annotation)
        self._keep(annotation)
        return annotation

    async def remove(self, annotation_id: str) -> None:
        """Take an annotation off the map; it stays in the database, marked as deleted.

        Raises:
            ApiError: there is none of that id.
        """
        if annotation_id not in self._annotations:
            raise unknown("annotation", annotation_id)
        annotation = self._annotations[annotation_id]
        await self._store.findings.record_annotation(self._mission_id, annotation, deleted=True)
        self._annotations.pop(annotation_id, None)
        self._board.publish({f"annotation/{annotation_id}": None})

    def _keep(self, annotation: AnnotationRecord) -> None:
        self._annotations[annotation.annotation_id] = annotation
        self._board.publish({f"annotation/{annotation.annotation_id}": annotation_value(annotation)})
