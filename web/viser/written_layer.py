"""What people put on the map: notes and hazards, sectors, photos."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import viser

from web.viser.colors import Palette
from web.viser.kept import Kept
from web.viser.picking import SOLIDS
from web.viser.places import Corners, Place, Value, Values, corners_of, of_kind, photo_places, place_of
from web.viser.shapes import dashed, outline

_ABOVE_FLOOR_M = 0.07
_LONGEST = 40  # letters of a label: more covers what is behind it
_NOTE_COLORS = {"hazard": "warn", "note": "note", "searched": "cleared", "victim": "danger", "exit": "good"}
# as on the plan (static/console/sectors.js)
_SECTOR_LOOKS = {
    "unassigned": ("○", "text-soft"),
    "under_way": ("▶", "accent"),
    "searched": ("✓", "good"),
    "second_look": ("↻", "warn"),
}


class NoteLooks(NamedTuple):
    """A note at its place, over an area or none."""

    kind: str
    label: str
    place: Place
    corners_m: Corners


class SectorLooks(NamedTuple):
    """A sector: its status, what it is called and who searches it, and its corners."""

    status: str
    label: str
    corners_m: Corners


class PhotoLooks(NamedTuple):
    """All photos of one thing or place."""

    number: int
    place: Place


class Written(NamedTuple):
    """All that people put on the map, by id."""

    notes: dict[str, NoteLooks]
    sectors: dict[str, SectorLooks]
    photos: dict[str, PhotoLooks]


def written_on(values: Values) -> Written:
    """Return what people put on the map of a board."""
    places = {note_id: place_of(values, "note", note_id) for note_id, _ in of_kind(values, "annotation")}
    notes = {
        note_id: NoteLooks(note["kind"], _short(note["text"] or note["kind"]), place, corners_of(note))
        for note_id, note in of_kind(values, "annotation")
        if (place := places[note_id]) is not None
    }
    sectors = {
        sector_id: SectorLooks(sector["status"], _sector_label(sector), corners_of(sector))
        for sector_id, sector in of_kind(values, "sector")
    }
    photos = {photo_id: PhotoLooks(count, place) for photo_id, (place, count) in photo_places(values).items()}
    return Written(notes, sectors, photos)


def _sector_label(sector: Value) -> str:
    who = ", ".join([*sector["robots"], *([sector["team"]] if sector["team"] else [])])
    return _short(f"{_SECTOR_LOOKS[sector['status']][0]} {sector['name']}{' · ' if who else ''}{who}")


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST - 1]}…"


class WrittenLayer:
    """Draws it. Words of people become labels alone: viser draws those as glyphs, never as HTML."""

    def __init__(self, server: viser.ViserServer, palette: Palette):
        self._server = server
        self._scene = server.scene
        self._palette = palette
        self._notes: Kept[NoteLooks] = Kept(self._scene, "/notes", self._note)
        self._sectors: Kept[SectorLooks] = Kept(self._scene, "/sectors", self._sector)
        self._photos: Kept[PhotoLooks] = Kept(self._scene, "/photos", self._photo)

    def show(self, written: Written) -> None:
        """Bring the scene to what people put on the map."""
        with self._server.atomic():
            self._notes.show(written.notes)
            self._sectors.show(written.sectors)
            self._photos.show(written.photos)

    def _note(self, name: str, looks: NoteLooks) -> None:
        color = self._palette[_NOTE_COLORS.get(looks.kind, "note")]
        height_m = SOLIDS["note"].height_m
        self._scene.add_frame(name, show_axes=False, position=(*looks.place, 0.0))
        self._pole(f"{name}/pole", height_m, color)
        self._scene.add_box(
            f"{name}/head",
            color,
            dimensions=(0.3, 0.3, 0.3),
            position=(0.0, 0.0, height_m),
            cast_shadow=False,
            receive_shadow=False,
        )
        self._label(f"{name}/label", looks.label, (0.0, 0.0, height_m + 0.3))
        if looks.corners_m:
            around = outline(np.array(looks.corners_m) - looks.place, _ABOVE_FLOOR_M)
            self._scene.add_line_segments(
                f"{name}/area", around, color, thickness=2.0, thickness_units="screen"
            )

    def _sector(self, name: str, looks: SectorLooks) -> None:
        color = self._palette[_SECTOR_LOOKS[looks.status][1]]
        around = outline(np.array(looks.corners_m), _ABOVE_FLOOR_M)
        self._scene.add_frame(name, show_axes=False)
        self._scene.add_line_segments(
            f"{name}/outline",
            around if looks.status == "searched" else dashed(around),
            color,
            thickness=3.0,
            thickness_units="screen",
        )
        x_m, y_m = max(looks.corners_m, key=lambda corner: (corner[1], -corner[0]))
        self._label(f"{name}/label", looks.label, (x_m, y_m, _ABOVE_FLOOR_M))

    def _photo(self, name: str, looks: PhotoLooks) -> None:
        color, height_m = self._palette["note"], SOLIDS["photo"].height_m
        plain = {"cast_shadow": False, "receive_shadow": False}
        self._scene.add_frame(name, show_axes=False, position=(*looks.place, 0.0))
        self._pole(f"{name}/pole", height_m, color)
        self._scene.add_box(
            f"{name}/body", color, dimensions=(0.42, 0.16, 0.28), position=(0.0, 0.0, height_m), **plain
        )
        lens = self._palette["halo"]
        self._scene.add_icosphere(f"{name}/lens", 0.11, lens, position=(0.0, -0.08, height_m), **plain)
        if looks.number > 1:
            self._label(f"{name}/label", f"{looks.number} photos", (0.0, 0.0, height_m + 0.25))

    def _pole(self, name: str, height_m: float, color: tuple[int, int, int]) -> None:
        self._scene.add_cylinder(
            name, 0.03, height_m, color, position=(0.0, 0.0, height_m / 2.0), cast_shadow=False
        )

    def _label(self, name: str, text: str, position: tuple[float, float, float]) -> None:
        self._scene.add_label(name, text, position=position, anchor="bottom-center", font_screen_scale=0.85)
