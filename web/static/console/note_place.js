/** Where notes are. */

/** @import {Annotation, Tag} from "./types.js" */

/** Where a note stands: its point, its tag, or the middle of its area. @param {Annotation} note @param {Tag | undefined} tag */
export function placeOf(note, tag) {
  if (note.area_m.length) {
    return [0, 1].map((axis) => note.area_m.reduce((sum, corner) => sum + corner[axis], 0) / note.area_m.length);
  }
  return [note.x_m ?? tag?.x_m, note.y_m ?? tag?.y_m];
}
