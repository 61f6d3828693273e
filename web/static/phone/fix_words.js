/** Where somebody is who hears nodes, in words that need no map, as robots/routes/fix_words.py. */

import { say } from "./texts.js";
import { bearingFrom, compassPoint, metres } from "./words.js";

/** @import {Located} from "./locating.js" */
/** @import {Spot} from "./places.js" */
/** @import {PocketTag} from "./types.js" */
/** @typedef {import("./texts.js").Key} Key */

const THERE_M = 1;

/** Two standard deviations along its longest axis. @param {Spot} spot */
export function rightTo({ var_x, var_xy, var_y }) {
  return 2 * Math.sqrt(Math.max(0, (var_x + var_y) / 2 + Math.hypot((var_x - var_y) / 2, var_xy)));
}

/** @param {Located} found @param {PocketTag[]} tags @param {string[]} unknown @param {number | null} north */
export function fixText(found, tags, unknown, north) {
  const words = [];
  const { places, ring, fits, left_out } = found;
  if (ring) words.push(say("fix_ring", { far: metres(ring.range_m), tag: ring.node_id, doubt: metres(2 * ring.sd_m) }));
  places.slice(0, 2).forEach((place, k) => {
    const near = tags.map((tag) => ({ tag, far: Math.hypot(tag.x_m - place.x_m, tag.y_m - place.y_m) }))
      .reduce((a, b) => (b.far < a.far || (b.far === a.far && b.tag.tag_id < a.tag.tag_id) ? b : a));
    const key = /** @type {Key} */ (`fix_${k ? "or_" : ""}${near.far < THERE_M ? "at" : "near"}`);
    const way = compassPoint(bearingFrom(north, place.x_m - near.tag.x_m, place.y_m - near.tag.y_m), north);
    words.push(say(key, { far: metres(near.far), way, tag: near.tag.tag_id, doubt: metres(rightTo(place)) }));
  });
  if (places.length > 1) words.push(say("fix_walk"));
  if (!fits) words.push(say("fix_misfit"));
  if (left_out) words.push(say("fix_left_out", { tag: left_out }));
  return [...words, ...unknown.slice(0, 3).map((tag) => say("fix_unknown", { tag }))].join(" ");
}
