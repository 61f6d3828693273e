"""Photos in the report: small ones, within the page, as many as a file to hand over can hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from db.photos import PhotoRecord
from db.store import Store
from server.report.drawing import data_address
from server.report.html import Html, clock, join, tag, text

MAX_BYTES = 8_000_000  # of all photos together: a report still goes by mail


@dataclass(frozen=True, slots=True)
class Shot:
    """A photo with its small picture (JPEG)."""

    photo: PhotoRecord
    jpeg: bytes


@dataclass(frozen=True, slots=True)
class Album:
    """The photos of a report, oldest first; ``left_out``: how many more there are."""

    shots: tuple[Shot, ...] = ()
    left_out: int = 0

    def of_victim(self, victim_id: str) -> list[Shot]:
        """Return the photos of a victim."""
        return [shot for shot in self.shots if shot.photo.victim_id == victim_id]

    def of_others(self, victims: Iterable[str]) -> list[Shot]:
        """Return the photos that are of none of these victims."""
        told = set(victims)
        return [shot for shot in self.shots if shot.photo.victim_id not in told]


async def gather(store: Store, mission_id: str, max_bytes: int = MAX_BYTES) -> Album:
    """Return a mission's photos: those of victims go first where there is no room for all, then the newest.

    Raises:
        DatabaseError: the database cannot be read.
    """
    known = [photo for photo, deleted in await store.photos.photos_of(mission_id) if not deleted]
    by_worth = sorted(known, key=lambda photo: (photo.victim_id is None, -photo.created_unix_s))
    shots: list[Shot] = []
    room = max_bytes
    for photo in by_worth:
        jpeg = await store.photos.picture_of(mission_id, photo.photo_id, small=True)
        if jpeg is None or len(jpeg) > room:
            break
        room -= len(jpeg)
        shots.append(Shot(photo, jpeg))
    shots.sort(key=lambda shot: shot.photo.created_unix_s)
    return Album(tuple(shots), len(known) - len(shots))


def figures(shots: Iterable[Shot], subjects: Mapping[str, str] | None = None) -> Html:
    """Return photos side by side with who took each, when, and of what; ``subjects``: names by photo id."""
    parts = [_figure(shot, (subjects or {}).get(shot.photo.photo_id, "")) for shot in shots]
    return tag("div", *parts, class_="photos") if parts else Html("")


def _figure(shot: Shot, subject: str) -> Html:
    photo = shot.photo
    address = data_address(shot.jpeg, "image/jpeg")
    picture = Html(f'<img src="{address}" alt="{text(photo.text or "Photo without words")}">')
    taken = clock(photo.taken_unix_s or photo.created_unix_s)
    said = join((part for part in (subject, photo.text, f"{photo.by}, {taken}") if part), ". ")
    return tag("figure", picture, tag("figcaption", said))


def photos_part(album: Album, victims: Iterable[str], words: Mapping[str, str]) -> Html:
    """Return the photos that stand with no victim; ``words``: what a note says, by its id."""
    shots = album.of_others(victims)
    subjects = {shot.photo.photo_id: _subject(shot.photo, words) for shot in shots}
    none = "There is no photo." if not album.shots else "All of them are of victims."
    parts = [figures(shots, subjects) if shots else tag("p", none)]
    if album.left_out:
        words_of_rest = f"{album.left_out} more are left out to keep this file small; the server has them."
        parts.append(tag("p", words_of_rest, class_="small"))
    return tag("section", tag("h2", "Photos"), *parts)


def _subject(photo: PhotoRecord, words: Mapping[str, str]) -> str:
    if photo.annotation_id is not None:
        return words.get(photo.annotation_id, "")[:80]
    if photo.tag_id is not None:
        return f"At tag {photo.tag_id}"
    return "" if photo.x_m is None or photo.y_m is None else f"At {photo.x_m:.1f} / {photo.y_m:.1f} m"
