/** Where this phone is by how far off nodes sound; the model and its reasons are in robots/estimation/radio/locating.py. */

import { CELLS, costsOn, logSd, NEAREST_M, piecesOf, readingCost } from "./likelihood.js";

/** @import {Box, Ground, Row, Shared, Since} from "./likelihood.js" */
/** @typedef {{node_id: string, x_m: number, y_m: number, place_sd_m: number, range_m: number, log_sd: number, sd_m: number}} Heard */
/** @typedef {{x_m: number, y_m: number, var_x: number, var_xy: number, var_y: number, share: number, is_hollow: boolean}} Spot */
/** @typedef {{node_id: string, range_m: number, sd_m: number}} Ring */
/** @typedef {{places: Spot[], ring: Ring | null, left_out: string | null, fits: boolean}} Located */
/** Own middle, and that of another piece. @typedef {[number, number, number, number]} Border */

const MOST = 12;
const BEYOND_SD = 3;
const TO_ZOOM = 1e-4;
const TO_SPLIT = 1e-2;
const SHRUNK = 0.5;
const ZOOMS = 14;
const PLACES = 6;
const LEAST_SHARE = 0.03;
const HOLLOW = 0.1;
const FITS_SD = 4;
const RING_STEPS = 400;

/** @param {Heard[]} heard each node once @param {Shared} shared @param {Since | null} since @param {Ground | null} ground @returns {Located | null} null where nothing was heard */
export function locate(heard, shared, since, ground) {
  const isNumber = (/** @type {Heard} */ { x_m, y_m, place_sd_m, range_m, log_sd, sd_m }) => [x_m, y_m, place_sd_m, range_m, log_sd, sd_m].every(Number.isFinite);
  const nearest = heard.filter(isNumber).sort((a, b) => a.range_m - b.range_m || (a.node_id < b.node_id ? -1 : 1)).slice(0, MOST);
  if (!nearest.length) return null;
  if (nearest.length === 1 && !since) return { places: [], ring: ringOf(nearest[0], shared), left_out: null, fits: true };
  const [places, cost] = placesOf(nearest, shared, since, ground);
  if (cost <= mostCost(nearest.length)) return { places, ring: null, left_out: null, fits: true };
  if (nearest.length > 3) {
    const tries = nearest.map((out) => ({ found: placesOf(nearest.filter((each) => each !== out), shared, since, ground), left_out: out.node_id }));
    const best = tries.reduce((a, b) => (b.found[1] < a.found[1] || (b.found[1] === a.found[1] && b.left_out < a.left_out) ? b : a));
    if (best.found[1] <= mostCost(nearest.length - 1)) return { places: best.found[0], ring: null, left_out: best.left_out, fits: true };
  }
  const wide = Math.max(1, cost / Math.max(1, nearest.length - 2));
  const wider = places.map((place) => ({ ...place, var_x: wide * place.var_x, var_xy: wide * place.var_xy, var_y: wide * place.var_y }));
  return { places: wider, ring: null, left_out: null, fits: false };
}

/** The places that fit, and what the readings cost at the best. @param {Heard[]} heard @param {Shared} shared @param {Since | null} since @param {Ground | null} ground
 * @returns {[Spot[], number]} */
function placesOf(heard, shared, since, ground) {
  /** @type {Row[]} */
  const rows = heard.map((h) => [h.x_m, h.y_m, h.place_sd_m, Math.max(h.range_m, NEAREST_M), h.log_sd, h.sd_m]);
  /** @type {{costs: Float64Array, box: Box}[]} */
  const drawn = [];
  /** @type {{box: Box, borders: Border[], depth: number}[]} */
  const waiting = [{ box: boxOf(rows, shared, since), borders: [], depth: 0 }];
  for (let next = waiting.pop(); next && drawn.length < PLACES; next = waiting.pop()) {
    const { box, borders, depth } = next;
    const costs = within(costsOn(rows, box, shared, since, ground), box, borders);
    const weights = weightsOf(costs);
    const pieces = piecesOf(weights, TO_SPLIT);
    const outline = outlineOf(weights);
    if (depth < ZOOMS && pieces.length > 1) {
      const middles = pieces.map(([r, c]) => [box[0] + (c + 0.5) * box[2], box[1] + (r + 0.5) * box[3]]);
      for (let k = pieces.length - 1; k >= 0; k -= 1) {
        const others = middles.filter((_, j) => j !== k).map((other) => /** @type {Border} */ ([...middles[k], ...other]));
        waiting.push({ box: cut(box, pieces[k].slice(2)), borders: [...borders, ...others], depth: depth + 1 });
      }
    } else if (depth < ZOOMS && Math.max(outline[1] - outline[0], outline[3] - outline[2]) + 1 <= SHRUNK * CELLS) {
      waiting.push({ box: cut(box, outline), borders, depth: depth + 1 });
    } else drawn.push({ costs, box });
  }
  const least = Math.min(...drawn.map(({ costs }) => leastOf(costs)));
  const masses = drawn.map(({ costs, box }) => costs.reduce((sum, cost) => sum + Math.exp(-0.5 * (cost - least)), 0) * box[2] * box[3]);
  const total = masses.reduce((sum, mass) => sum + mass, 0);
  const places = drawn.map(({ costs, box }, k) => momentsOf(costs, box, masses[k] / total)).filter(({ share }) => share >= LEAST_SHARE);
  const cost = Math.min(...drawn.map(({ costs, box }) => {
    const at = costs.indexOf(leastOf(costs));
    const [x, y] = [box[0] + ((at % CELLS) + 0.5) * box[2], box[1] + (Math.floor(at / CELLS) + 0.5) * box[3]];
    return readingCost(rows, x, y, box[2] / 2, box[3] / 2, shared, ground).cost;
  }));
  return [places.sort((a, b) => b.share - a.share), cost];
}

/** Leave out cells that are nearer to another piece. @param {Float64Array} costs @param {Box} box @param {Border[]} borders */
function within(costs, box, borders) {
  for (const [ownX, ownY, otherX, otherY] of borders) {
    for (let at = 0; at < costs.length; at += 1) {
      const [x, y] = [box[0] + ((at % CELLS) + 0.5) * box[2], box[1] + (Math.floor(at / CELLS) + 0.5) * box[3]];
      if ((x - otherX) ** 2 + (y - otherY) ** 2 < (x - ownX) ** 2 + (y - ownY) ** 2) costs[at] = Infinity;
    }
  }
  return costs;
}

/** @param {Float64Array} costs */
const leastOf = (costs) => costs.reduce((least, cost) => Math.min(least, cost), Infinity);

/** @param {Float64Array} costs */
function weightsOf(costs) {
  const least = leastOf(costs);
  return costs.map((cost) => Math.exp(-0.5 * (cost - least)));
}

/** First and last row and column of what counts. @param {Float64Array} weights */
function outlineOf(weights) {
  let [top, bottom, left, right] = [CELLS, -1, CELLS, -1];
  weights.forEach((weight, at) => {
    if (weight <= TO_ZOOM) return;
    const [row, column] = [Math.floor(at / CELLS), at % CELLS];
    [top, bottom, left, right] = [Math.min(top, row), Math.max(bottom, row), Math.min(left, column), Math.max(right, column)];
  });
  return [top, bottom, left, right];
}

/** @param {Box} box @param {number[]} kept @returns {Box} */
function cut([x, y, sizeX, sizeY], [top, bottom, left, right]) {
  const [aside, above] = [1 + Math.floor((right - left) / 4), 1 + Math.floor((bottom - top) / 4)];
  const [wide, high] = [(right - left + 1 + 2 * aside) * sizeX, (bottom - top + 1 + 2 * above) * sizeY];
  return [x + (left - aside) * sizeX, y + (top - above) * sizeY, wide / CELLS, high / CELLS];
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

/** @param {Float64Array} costs @param {Box} box @param {number} share @returns {Spot} */
function momentsOf(costs, box, share) {
  const weights = weightsOf(costs);
  let [sum, x, y] = [0, 0, 0];
  const at = (/** @type {number} */ k) => [box[0] + ((k % CELLS) + 0.5) * box[2], box[1] + (Math.floor(k / CELLS) + 0.5) * box[3]];
  weights.forEach((weight, k) => {
    const [cx, cy] = at(k);
    [sum, x, y] = [sum + weight, x + weight * cx, y + weight * cy];
  });
  [x, y] = [x / sum, y / sum];
  let [xx, xy, yy] = [0, 0, 0];
  weights.forEach((weight, k) => {
    const [cx, cy] = at(k);
    [xx, xy, yy] = [xx + weight * (cx - x) ** 2, xy + weight * (cx - x) * (cy - y), yy + weight * (cy - y) ** 2];
  });
  const middle = Math.trunc((y - box[1]) / box[3]) * CELLS + Math.trunc((x - box[0]) / box[2]);
  return { x_m: x, y_m: y, var_x: xx / sum, var_xy: xy / sum, var_y: yy / sum, share, is_hollow: weights[middle] < HOLLOW };
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
