"""Words that people's phones left in tags, brought home by robots: shown once, whichever way they come."""

from __future__ import annotations

import re
import time
from typing import get_args
from uuid import UUID, uuid5

from db.records import AnnotationKind, AnnotationRecord
from robots.tags.marks import MAX_NAME, MAX_TEXT
from robots.tags.sealed import unsealed_notes
from server.mission.annotations import Annotations

_SPACE = UUID("6d0f1a2e-6a57-4b0e-9c1b-5e2f0c7d3a91")
_NOBODY = "?"  # a phone that has not heard yet who logged in there
_MOST = 50  # of one tag: a stranger's chip must not fill the map
_WORD = re.compile(rf"({'|'.join(get_args(AnnotationKind))}): ?(.*)", re.DOTALL)


class ChipNotes:
    """Puts unsealed notes on the map, at their tag and as what they are: nobody vouches for them."""

    def __init__(self, annotations: Annotations, key: bytes) -> None:
        self._annotations = annotations
        self._key = key
        self._known: dict[str, bytes] = {}  # records that were looked at, by tag
        self._victims: set[tuple[str, str, str]] = set()  # reported ones: tag, author and text as in a tag

    async def take(self, tag_id: str, records: bytes) -> None:
        """Show the notes in what was read from a tag that are not on the map yet.

        Raises:
            DatabaseError: one could not be kept.
        """
        if self._known.get(tag_id) == records:
            return
        for note in unsealed_notes(records, tag_id, self._key)[:_MOST]:
            found = _WORD.fullmatch(note.text)
            kind: AnnotationKind = found[1] if found else "note"  # type: ignore[assignment]  # the pattern has no other
            text = found[2] if found else note.text
            if self._was_reported(tag_id, note.author, note.text):
                continue
            now = time.time()
            await self._annotations.put(
                AnnotationRecord(
                    annotation_id=chip_note_id(tag_id, note.author, note.text),
                    kind=kind,
                    text=text,
                    x_m=None,
                    y_m=None,
                    tag_id=tag_id,
                    by=f"{note.author} (in the tag, without seal)",
                    created_unix_s=now,
                    changed_unix_s=now,
                )
            )
        self._known[tag_id] = records

    def is_copy(self, note: AnnotationRecord) -> bool:
        """Say whether a reported note was read off a tag, and its writer has reported it already."""
        known = note.tag_id or "", *_as_in_tag(note.by, f"{note.kind}: {note.text}")
        return note.annotation_id == chip_note_id(*known) and self._was_reported(*known)

    async def is_reported(self, note: AnnotationRecord) -> None:
        """Take a note off the map that came by its tag, now that its writer has reported it."""
        known = note.tag_id or "", *_as_in_tag(note.by, f"{note.kind}: {note.text}")
        await self._remove_copies(*known, but=note.annotation_id)

    def knows_victim(
        self, tag_id: str, by: str, live: int | None, dead: int | None, text: str
    ) -> tuple[str, str, str]:
        """Take note of a victim that was reported; return tag, author and text of its word in the tag."""
        word = f"victim: L-{live or 0} D-{dead or 0} {text.strip()}".strip()  # as the phone writes it
        known = tag_id, *_as_in_tag(by, word)
        self._victims.add(known)
        return known

    async def victim_is_reported(
        self, tag_id: str, by: str, live: int | None, dead: int | None, text: str
    ) -> None:
        """Take a word of a victim off the map that came by its tag, now that its writer has reported it."""
        await self._remove_copies(*self.knows_victim(tag_id, by, live, dead, text))

    async def _remove_copies(self, tag_id: str, author: str, text: str, but: str = "") -> None:
        for copy in {chip_note_id(tag_id, name, text) for name in (author, _NOBODY)} - {but}:
            if self._annotations.value(copy) is not None:
                await self._annotations.remove(copy)

    def _was_reported(self, tag_id: str, author: str, text: str) -> bool:
        notes = self._annotations.all()
        words = {(n.tag_id or "", *_as_in_tag(n.by, f"{n.kind}: {n.text}")) for n in notes} | self._victims
        if author == _NOBODY:
            return (tag_id, text) in {(tag, said) for tag, _, said in words}
        return (tag_id, author, text) in words


def chip_note_id(tag_id: str, author: str, text: str) -> str:
    """Return the id on the map of a note in a tag."""
    return str(uuid5(_SPACE, f"{tag_id}\0{author}\0{text}"))


def _as_in_tag(author: str, text: str) -> tuple[str, str]:
    """Return what a tag has room for of an author and a text."""
    author = re.split(r" \((?:sent|carried) by ", author, maxsplit=1)[0]
    return _cut(author, MAX_NAME), _cut(text, MAX_TEXT)


def _cut(text: str, most: int) -> str:
    return text.encode()[:most].decode("utf-8", "ignore")
