/** Ways in words: how far, which way by the compass, where to turn. As robots/routes/words.py says it. */

import { UNNAMED } from "./hazards.js";
import { say } from "./texts.js";

/** @import {Edge, Roads} from "./roads.js" */
/** @import {Step} from "./types.js" */
/** @typedef {import("./texts.js").Key} Key */

/** @type {Key[]} */
const POINTS = ["north", "north_east", "east", "south_east", "south", "south_west", "west", "north_west"];
const STRAIGHT_DEG = 35; // a smaller turn is no turn
const ROUND_DEG = 145;
const NARROW_CM = 75;
const UNCERTAIN_M = 1;
const UNCERTAIN_SHARE = 0.25;

/** To the nearest whole number, halves to the even one, as Python does. @param {number} value */
export function rounded(value) {
  const down = Math.floor(value);
  const part = value - down;
  return part > 0.5 || (part === 0.5 && down % 2 !== 0) ? down + 1 : down;
}

/** @param {number} distance_m */
export const metres = (distance_m) => say("metres", { n: Math.max(1, rounded(distance_m)) });

/** Compass bearing, 0 to 360; x points north, y west. @param {number} dx @param {number} dy */
export function bearing(dx, dy) {
  const degrees = (-Math.atan2(dy, dx) * 180) / Math.PI;
  return degrees < 0 ? degrees + 360 : degrees + 0;
}

/** Bearing from true north, or from the plan's where that is not known. @param {number | null} north true bearing of the plan's x @param {number} dx @param {number} dy */
export const bearingFrom = (north, dx, dy) => (bearing(dx, dy) + (north ?? 0)) % 360;

/** @param {number} degrees @param {number | null} north */
export function compassPoint(degrees, north) {
  const way = say(POINTS[rounded(degrees / 45) % 8]);
  return north === null ? say("of_plan", { way }) : way;
}

/** @param {number} sd_m @param {number} length_m */
const isUncertain = (sd_m, length_m) => sd_m > UNCERTAIN_M || sd_m > UNCERTAIN_SHARE * length_m;

/** A leg of a route. @param {Roads} roads @param {number} from @param {Edge} edge @returns {Step} */
export function legOf(roads, from, edge) {
  const points = inMetres(edge.points);
  const [start, end] = [roads.tags[from], roads.tags[edge.to]];
  const length_m = lengthAlong(edge);
  const uncertain = edge.way[6] > 0 || isUncertain(Math.hypot(start.sd_m, end.sd_m), length_m);
  return {
    from_tag: start.tag_id,
    to_tag: end.tag_id,
    distance_m: length_m,
    bearing_deg: bearingFrom(roads.north, points[1][0] - points[0][0], points[1][1] - points[0][1]),
    text: legText(points, end.tag_id, length_m, uncertain, edge, roads.north),
    uncertain,
    hazards: edge.hazards,
    points_m: points,
  };
}

/** @param {[number, number][]} points @param {string} toTag @param {number} length_m @param {boolean} uncertain @param {Edge} edge @param {number | null} north */
function legText(points, toTag, length_m, uncertain, { way, hazards }, north) {
  const [, , , , , width, walked] = way;
  const pieces = piecesOf(points, uncertain, north, walked ? length_m : null);
  const words = [say("leg", { pieces: capital(pieces.join(", ")), tag: toTag })];
  if (walked) words.push(say("walked"));
  if (width && width < NARROW_CM) words.push(say("narrow", { width: 10 * rounded(width / 10) }));
  return withCare(words.join(" "), hazards);
}

/** @param {string} text @param {string[]} hazards */
const withCare = (text, hazards) => [text, ...hazards.map((hazard) => say("take_care", { hazard: hazard === UNNAMED ? say("a_hazard") : hazard }))].join(" ");

/** @param {[number, number][]} points @param {boolean} uncertain @param {number | null} north @param {number | null} walked_m of a straight line, its length on foot */
function piecesOf(points, uncertain, north, walked_m) {
  /** @type {{key: Key, way: string, run_m: number}[]} */
  const runs = [];
  let before = 0;
  points.slice(1).forEach(([x, y], k) => {
    const [dx, dy] = [x - points[k][0], y - points[k][1]];
    const now = bearingFrom(north, dx, dy);
    const turn = modulo(now - before + 180, 360) - 180;
    if (!runs.length) runs.push({ key: "go", way: compassPoint(now, north), run_m: 0 });
    else if (Math.abs(turn) > STRAIGHT_DEG) {
      runs.push({ key: Math.abs(turn) > ROUND_DEG ? "turn_round" : turn < 0 ? "turn_left" : "turn_right", way: "", run_m: 0 });
    }
    runs[runs.length - 1].run_m += Math.hypot(dx, dy);
    before = now;
  });
  if (walked_m !== null) runs[0].run_m = walked_m;
  return runs.map(({ key, way, run_m }) => say(key, { way, far: uncertain ? say("about", { far: metres(run_m) }) : metres(run_m) }));
}

/** The last piece, from the last tag to what is looked for. @param {Roads} roads @param {number} from @param {[number, number]} place @param {string} goal @param {number} sd_m of the place @returns {Step} */
export function lastOf(roads, from, place, goal, sd_m) {
  const tag = roads.tags[from];
  const [dx, dy] = [place[0] - tag.x_m, place[1] - tag.y_m];
  const [distance_m, bearing_deg] = [Math.hypot(dx, dy), bearingFrom(roads.north, dx, dy)];
  const hazards = roads.hazardsNear([tag.x_m, tag.y_m, ...place].map((number) => Math.round(100 * number)));
  const off_m = Math.hypot(tag.sd_m, sd_m);
  const uncertain = off_m > UNCERTAIN_M;
  const words = { tag: tag.tag_id, far: metres(distance_m), way: compassPoint(bearing_deg, roads.north), goal, doubt: metres(2 * off_m) };
  const text = withCare(say(uncertain ? "last_leg_unsure" : "last_leg", words), hazards);
  const points_m = /** @type {[number, number][]} */ ([[tag.x_m, tag.y_m], place]);
  return { from_tag: tag.tag_id, to_tag: null, distance_m, bearing_deg, text, uncertain, hazards, points_m };
}

/** @param {number[]} points cm @returns {[number, number][]} */
export function inMetres(points) {
  /** @type {[number, number][]} */
  const found = [];
  for (let k = 0; k < points.length; k += 2) found.push([points[k] / 100, points[k + 1] / 100]);
  return found;
}

/** @param {[number, number][]} points */
const lengthOf = (points) => points.slice(1).reduce((sum, [x, y], k) => sum + Math.hypot(x - points[k][0], y - points[k][1]), 0);

/** How long a way is: as somebody walked it, else by its points. @param {Edge} edge */
export const lengthAlong = ({ way, points }) => (way[6] ? way[6] / 100 : lengthOf(inMetres(points)));

/** @param {number} value @param {number} by */
const modulo = (value, by) => ((value % by) + by) % by;

/** @param {string} text */
const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
