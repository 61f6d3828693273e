/** Where this phone is by how far off nodes sound; the model and its reasons are in robots/estimation/radio/locating.py. */

import { CELLS, costsOn, logSd, NEAREST_M, readingCost } from "./likelihood.js";
import { drawn, placesOf } from "./places.js";

/** @import {Box, Ground, Row, Shared, Since} from "./likelihood.js" */
/** @import {Spot} from "./places.js" */
/** @typedef {{node_id: string, x_m: number, y_m: number, place_sd_m: number, range_m: number, log_sd: number, sd_m: number}} Heard */
/** @typedef {{node_id: string, range_m: number, sd_m: number}} Ring */
/** @typedef {{places: Spot[], ring: Ring | null, left_out: string | null, fits: boolean}} Located */

const MOST = 12;
const BEYOND_SD = 3;
const FITS_SD = 4;
const RING_STEPS = 400;

/** @param {Heard[]} heard each node once @param {Shared} shared @param {Since | null} since @param {Ground | null} ground @returns {Located | null} null where nothing was heard */
export function locate(heard, shared, since, ground) {
  const isNumber = (/** @type {Heard} */ { x_m, y_m, place_sd_m, range_m, log_sd, sd_m }) => [x_m, y_m, place_sd_m, range_m, log_sd, sd_m].every(Number.isFinite);
  const nearest = heard.filter(isNumber).sort((a, b) => a.range_m - b.range_m || (a.node_id < b.node_id ? -1 : 1)).slice(0, MOST);
  if (!nearest.length) return null;
  if (nearest.length === 1 && !since) return { places: [], ring: ringOf(nearest[0], shared), left_out: null, fits: true };
  const [places, cost] = fitting(nearest, shared, since, ground);
  if (cost <= mostCost(nearest.length)) return { places, ring: null, left_out: null, fits: true };
  if (nearest.length > 3) {
    const tries = nearest.map((out) => ({ found: fitting(nearest.filter((each) => each !== out), shared, since, ground), left_out: out.node_id }));
    const best = tries.reduce((a, b) => (b.found[1] < a.found[1] || (b.found[1] === a.found[1] && b.left_out < a.left_out) ? b : a));
    if (best.found[1] <= mostCost(nearest.length - 1)) return { places: best.found[0], ring: null, left_out: best.left_out, fits: true };
  }
  const wide = Math.max(1, cost / Math.max(1, nearest.length - 2));
  const wider = places.map((place) => ({ ...place, var_x: wide * place.var_x, var_xy: wide * place.var_xy, var_y: wide * place.var_y }));
  return { places: wider, ring: null, left_out: null, fits: false };
}

/** The places that fit, and what the readings cost at the best. @param {Heard[]} heard @param {Shared} shared @param {Since | null} since @param {Ground | null} ground
 * @returns {[Spot[], number]} */
function fitting(heard, shared, since, ground) {
  /** @type {Row[]} */
  const rows = heard.map((h) => [h.x_m, h.y_m, h.place_sd_m, Math.max(h.range_m, NEAREST_M), h.log_sd, h.sd_m]);
  const cells = drawn((box) => costsOn(rows, box, shared, since, ground), boxOf(rows, shared, since));
  const [x, y, wide, high] = cells.reduce((a, b) => (b[4] < a[4] ? b : a));
  return [placesOf(cells), readingCost(rows, x, y, wide / 2, high / 2, shared, ground).cost];
}

/** @param {Row[]} rows @param {Shared} shared @param {Since | null} since @returns {Box} */
function boxOf(rows, shared, since) {
  const rounds = rows.map(([x, y, place_sd, range, log_sd, sd]) => {
    const spread = log_sd > 0 ? Math.hypot(log_sd, logSd(shared, range)) : 0;
    const reach = range * Math.exp(BEYOND_SD * spread) + BEYOND_SD * (sd + place_sd) + NEAREST_M;
    return { x, y, half: log_sd > 0 ? Math.min(reach, 3 * shared.reach_m) : reach };
  });
  if (since) rounds.push({ x: since.x_m, y: since.y_m, half: since.at_most_m + BEYOND_SD * since.sd_m + NEAREST_M });
  let low = [Math.max(...rounds.map(({ x, half }) => x - half)), Math.max(...rounds.map(({ y, half }) => y - half))];
  let high = [Math.min(...rounds.map(({ x, half }) => x + half)), Math.min(...rounds.map(({ y, half }) => y + half))];
  if (high[0] <= low[0] || high[1] <= low[1]) {
    const { x, y, half } = rounds.reduce((a, b) => (b.half < a.half ? b : a));
    [low, high] = [[x - half, y - half], [x + half, y + half]];
  }
  return [low[0], low[1], (high[0] - low[0]) / CELLS, (high[1] - low[1]) / CELLS];
}

/** @param {Heard} heard @param {Shared} shared @returns {Ring} */
function ringOf({ node_id, range_m, log_sd, sd_m, place_sd_m }, shared) {
  if (log_sd <= 0) return { node_id, range_m, sd_m: Math.hypot(sd_m, place_sd_m) };
  const centre = Math.min(range_m, shared.reach_m);
  const s = Math.hypot(log_sd, logSd(shared, centre));
  const furthest = Math.min(shared.reach_m, centre * Math.exp(5 * s));
  let [total, first, second] = [0, 0, 0];
  for (let k = 0; k < RING_STEPS; k += 1) {
    const d = ((k + 0.5) * furthest) / RING_STEPS;
    const weight = Math.exp(-0.5 * (Math.log(centre / d) / s) ** 2);
    [total, first, second] = [total + weight, first + weight * d, second + weight * d * d];
  }
  const mean = first / total;
  return { node_id, range_m: mean, sd_m: Math.hypot(Math.sqrt(Math.max(second / total - mean * mean, 0)), place_sd_m) };
}

/** @param {number} readings */
function mostCost(readings) {
  const free = Math.max(1, readings - 2);
  return free + FITS_SD * Math.sqrt(2 * free);
}
