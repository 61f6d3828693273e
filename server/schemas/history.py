"""A mission's past on the wire."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from server.schemas.common import Wire


class ChunkOut(Wire):
    """What one chunk of the past covers."""

    number: int
    begins_unix_s: float
    ends_unix_s: float = Field(description="Of its last change; the state stays so until the next chunk.")


class HistoryOut(Wire):
    """What is known of a mission's past."""

    begins_unix_s: float | None = Field(description="Of the first chunk; null while there is none.")
    ends_unix_s: float | None
    chunks: list[ChunkOut] = Field(description="Oldest first; the last one may still grow.")


class HistoryStateOut(Wire):
    """What a mission showed at one moment."""

    unix_s: float = Field(description="When it became so: the moment asked for, or earlier.")
    state: dict[str, Any] = Field(description="As `state` of the stream's snapshot was then.")
