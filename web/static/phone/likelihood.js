/** How well each cell of a grid fits what is heard of nodes, as robots/estimation/radio/likelihood.py. */

/** A row: place, its deviation, range, deviations of its logarithm and in metres. @typedef {[number, number, number, number, number, number]} Row */
/** Lowest x and y, size of a cell. @typedef {[number, number, number, number]} Box */
/** In ln d: deviation of the gain, what a wall takes, and deviations of the shadowing at distances; the reach in metres; the exponent's
 * deviation as a share. @typedef {{gain_sd: number, wall: number, reach_m: number, exponent_sd: number, distances_m: number[], shadow_sds: number[]}} Shared */
/** @typedef {{x_m: number, y_m: number, sd_m: number, at_most_m: number}} Since */
/** Classes 0 unknown, 1 free, 2 wall, row 0 at the lowest y. @typedef {{classes: Uint8Array, width: number, height: number, origin_m: number[], resolution_m: number}} Ground */

export const CELLS = 48;
export const NEAREST_M = 0.05;
const FREE = 1;
const WALL = 2;
const UNKNOWN_COST = 6;
const WALL_COST = 8;
const MOST_WALLS = 8;
const NARROW = 0.1;
const APART_M = 0.25;
const WALL_VARIANCE = 0.25;
const HIDDEN = 0.5;

/** -2 ln of the probability of each cell, but for a constant. @param {Row[]} rows @param {Box} box @param {Shared} shared
 * @param {Since | null} since @param {Ground | null} ground */
export function costsOn(rows, box, shared, since, ground) {
  const found = new Float64Array(CELLS * CELLS);
  const [half_x, half_y] = [box[2] / 2, box[3] / 2];
  for (let i = 0; i < CELLS; i += 1) {
    for (let j = 0; j < CELLS; j += 1) {
      const [x, y] = [box[0] + (j + 0.5) * box[2], box[1] + (i + 0.5) * box[3]];
      const { cost, details } = readingCost(rows, x, y, half_x, half_y, shared, ground);
      let total = cost + details;
      if (ground) total += groundCost(ground, x, y);
      if (since) {
        const over = Math.max(0, Math.hypot(x - since.x_m, y - since.y_m) - since.at_most_m);
        total += (over * over) / (since.sd_m * since.sd_m + half_x * half_x + half_y * half_y);
      }
      found[i * CELLS + j] = total;
    }
  }
  return found;
}

/** Chi-square of the readings at a place, and what their densities add to it.
 * @param {Row[]} rows @param {number} x @param {number} y @param {number} half_x @param {number} half_y @param {Shared} shared @param {Ground | null} ground */
export function readingCost(rows, x, y, half_x, half_y, shared, ground) {
  let [cost, details] = [0, 0];
  let [gg, gn, nn, ge, ne] = [1, 0, 1, 0, 0];
  for (const [nx, ny, place_sd, range, log_sd, sd] of rows) {
    const [dx, dy] = [x - nx, y - ny];
    const far = Math.max(Math.hypot(dx, dy), NEAREST_M);
    const blur = ((dx * half_x) ** 2 + (dy * half_y) ** 2) / (far * far);
    const placed = place_sd * place_sd + blur;
    let error, variance;
    if (log_sd > 0) {
      error = Math.log(range / far);
      const shadow = shadowAt(far, shared);
      variance = log_sd * log_sd + shadow * shadow + placed / (far * far + blur);
      if (ground && shared.wall > 0) {
        const count = wallsBetween(ground, nx, ny, x, y);
        error -= shared.wall * count;
        variance += WALL_VARIANCE * shared.wall * shared.wall * (count + HIDDEN);
      }
      const beyond = Math.max(0, far / shared.reach_m - 1) / NARROW;
      details += beyond * beyond;
      const [byGain, byExponent] = [shared.gain_sd, shared.exponent_sd * Math.log(far)];
      gg += (byGain * byGain) / variance;
      gn += (byGain * byExponent) / variance;
      nn += (byExponent * byExponent) / variance;
      ge += (byGain * error) / variance;
      ne += (byExponent * error) / variance;
    } else {
      error = range - far;
      variance = sd * sd + placed;
    }
    cost += (error * error) / variance;
    details += Math.log(variance);
  }
  const determinant = gg * nn - gn * gn;
  cost -= (nn * ge * ge - 2 * gn * ge * ne + gg * ne * ne) / determinant;
  return { cost, details: details + Math.log(determinant) };
}

/** The deviation of the shadowing at a distance. @param {number} far @param {Shared} shared */
function shadowAt(far, { distances_m, shadow_sds }) {
  const k = distances_m.findIndex((distance) => far <= distance);
  if (k === 0) return shadow_sds[0];
  if (k < 0) return shadow_sds[shadow_sds.length - 1];
  const share = (far - distances_m[k - 1]) / (distances_m[k] - distances_m[k - 1]);
  return shadow_sds[k - 1] + share * (shadow_sds[k] - shadow_sds[k - 1]);
}

/** The deviation in ln d of a signal from so far, but for its fading. @param {Shared} shared @param {number} far */
export function logSd(shared, far) {
  return Math.hypot(shadowAt(far, shared), shared.gain_sd, shared.exponent_sd * Math.log(Math.max(far, NEAREST_M)));
}

/** @param {Ground} ground @param {number} x @param {number} y */
function groundCost({ classes, width, height, origin_m, resolution_m }, x, y) {
  const [column, row] = [Math.floor((x - origin_m[0]) / resolution_m), Math.floor((y - origin_m[1]) / resolution_m)];
  if (row < 0 || column < 0 || row >= height || column >= width) return UNKNOWN_COST;
  const kind = classes[row * width + column];
  return kind === FREE ? 0 : kind === WALL ? WALL_COST : UNKNOWN_COST;
}

/** How many walls the line from a node crosses: two faces with no free ground between are one. @param {Ground} ground @param {number} fromX @param {number} fromY @param {number} toX @param {number} toY */
function wallsBetween({ classes, width, height, origin_m, resolution_m }, fromX, fromY, toX, toY) {
  const [x0, y0] = [(fromX - origin_m[0]) / resolution_m, (fromY - origin_m[1]) / resolution_m];
  const [x1, y1] = [(toX - origin_m[0]) / resolution_m, (toY - origin_m[1]) / resolution_m];
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length === 0) return 0;
  const [dx, dy] = [(x1 - x0) / length, (y1 - y0) / length];
  let [column, row] = [Math.floor(x0), Math.floor(y0)];
  const [stepC, stepR] = [dx > 0 ? 1 : -1, dy > 0 ? 1 : -1];
  let nextC = dx !== 0 ? (column + (dx > 0 ? 1 : 0) - x0) / dx : Infinity;
  let nextR = dy !== 0 ? (row + (dy > 0 ? 1 : 0) - y0) / dy : Infinity;
  const [deltaC, deltaR] = [dx !== 0 ? Math.abs(1 / dx) : Infinity, dy !== 0 ? Math.abs(1 / dy) : Infinity];
  let [t, free, count, inside] = [0, 0, 0, false];
  while (t < length && count < MOST_WALLS) {
    if (row < 0 || column < 0 || row >= height || column >= width) break;
    const [kind, before] = [classes[row * width + column], t];
    t = Math.min(nextC, nextR);
    if (kind === WALL) {
      if (!inside) count += 1;
      [inside, free] = [true, 0];
    } else if (kind === FREE) {
      free += t - before;
      inside = inside && free < APART_M / resolution_m;
    }
    if (nextC < nextR) {
      nextC += deltaC;
      column += stepC;
    } else {
      nextR += deltaR;
      row += stepR;
    }
  }
  return count;
}
