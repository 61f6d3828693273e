/** What people keep away from, and which ways come near it. As robots/routes/hazards.py, in centimetres and squares. */

/** @import {PocketNote} from "./types.js" */
/** @typedef {[number, number]} Point */
/** `corners`: one for a point, three and more for an area. @typedef {{text: string, corners: Point[]}} Hazard */

const REACH_CM = 200;
export const UNNAMED = "hazard"; // where nobody has said what it is

/** @param {PocketNote[]} notes @returns {Hazard[]} */
export function hazardsOf(notes) {
  return notes.filter(({ kind, x_m }) => kind === "hazard" && x_m !== null).map((note) => ({
    text: note.text || UNNAMED,
    corners: (note.area_m.length ? note.area_m : [[note.x_m ?? 0, note.y_m ?? 0]]).map(([x, y]) => [100 * x, 100 * y]),
  }));
}

/**
 * Whether a line comes within 2 m of a hazard: of its sides, or into it.
 * @param {number[]} points x, y, x, y, ... in cm
 * @param {Hazard} hazard
 */
export function isNear(points, { corners }) {
  const xs = corners.map(([x]) => x);
  const ys = corners.map(([, y]) => y);
  const low = [Math.min(...xs) - REACH_CM, Math.min(...ys) - REACH_CM];
  const high = [Math.max(...xs) + REACH_CM, Math.max(...ys) + REACH_CM];
  const isArea = corners.length >= 3;
  for (let k = 0; k + 3 < points.length; k += 2) {
    const [x0, y0, x1, y1] = points.slice(k, k + 4);
    if (Math.max(x0, x1) < low[0] || Math.max(y0, y1) < low[1] || Math.min(x0, x1) > high[0] || Math.min(y0, y1) > high[1]) continue;
    /** @type {[Point, Point]} */
    const [start, end] = [[x0, y0], [x1, y1]];
    if (isArea && (isInside(start, corners) || isInside(end, corners))) return true;
    for (let side = 0; side < corners.length; side += 1) {
      const [one, other] = [corners[side], corners[(side + 1) % corners.length]];
      if (isArea && cross(start, end, one, other)) return true;
      if (Math.min(off(start, one, other), off(end, one, other), off(one, start, end)) < REACH_CM * REACH_CM) return true;
    }
  }
  return false;
}

/** The squared distance of a point to the piece from start to end. @param {Point} point @param {Point} start @param {Point} end */
function off(point, start, end) {
  const [px, py] = [point[0] - start[0], point[1] - start[1]];
  const [dx, dy] = [end[0] - start[0], end[1] - start[1]];
  const share = Math.min(1, Math.max(0, (px * dx + py * dy) / (dx * dx + dy * dy || 1)));
  const [ex, ey] = [px - share * dx, py - share * dy];
  return ex * ex + ey * ey;
}

/** @param {Point} a @param {Point} b @param {Point} c */
const isLeft = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0;

/** Whether the piece from start to end crosses that from one to other. @param {Point} start @param {Point} end @param {Point} one @param {Point} other */
const cross = (start, end, one, other) => isLeft(start, end, one) !== isLeft(start, end, other) && isLeft(one, other, start) !== isLeft(one, other, end);

/** A ray from the point crosses the sides of an area it is in an odd number of times. @param {Point} point @param {Point[]} corners */
function isInside([x, y], corners) {
  return corners.filter(([x0, y0], k) => {
    const [x1, y1] = corners[(k + 1) % corners.length];
    return y0 > y !== y1 > y && x < x0 + ((y - y0) * (x1 - x0)) / (y1 - y0);
  }).length % 2 === 1;
}
