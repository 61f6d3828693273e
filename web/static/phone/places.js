/** The places that a probability leaves: drawn finer and finer where it is, told apart where a gap is; as robots/estimation/radio/places.py. */

import { CELLS } from "./likelihood.js";

/** @import {Box} from "./likelihood.js" */
/** @typedef {{x_m: number, y_m: number, var_x: number, var_xy: number, var_y: number, share: number, is_hollow: boolean}} Spot */
/** Middle, size along x and y, cost. @typedef {[number, number, number, number, number]} Cell */
/** @typedef {{box: Box, costs: Float64Array}} Tile */
/** @typedef {{x: number, y: number, xx: number, xy: number, yy: number, mass: number}} Moments */

const KEPT = 18.4;
const CORE = 4;
const ENOUGH = 100;
const SHRUNK = 0.5;
const ROUNDS = 14;
const TILES = 16;
const HALVINGS = 3;
const BINS = 48;
const APART_SD = 2.5;
const LEAST_SHARE = 0.03;
const HOLLOW = 0.1;

/** The cells that are left of a box. @param {(box: Box) => Float64Array} costsOf @param {Box} box @returns {Cell[]} */
export function drawn(costsOf, box) {
  const draw = (/** @type {Box} */ own) => ({ box: own, costs: costsOf(own) });
  let tiles = [draw(box)];
  for (let round = 0; round < ROUNDS; round += 1) {
    const least = leastOf(tiles);
    if (tiles.reduce((sum, { costs }) => sum + costs.reduce((n, cost) => n + Number(cost < least + CORE), 0), 0) >= ENOUGH) break;
    let finer = tiles.flatMap((tile) => cuts(tile, least, CELLS));
    if (ground(finer) > SHRUNK * ground(tiles.map((tile) => tile.box))) finer = tiles.flatMap((tile) => cuts(tile, least, CELLS / 2));
    if (finer.length > TILES) break;
    tiles = finer.map(draw);
  }
  const least = leastOf(tiles);
  return tiles.flatMap((tile) => cellsOf(tile, least));
}

/** The places of cells, the most probable first; what has no real share is none. @param {Cell[]} cells @returns {Spot[]} */
export function placesOf(cells) {
  const best = bestOf(cells);
  let groups = [cells];
  for (let k = 0; k < HALVINGS; k += 1) groups = groups.flatMap(halves);
  while (groups.length > 1) {
    const pairs = groups.flatMap((one, i) => groups.slice(i + 1).map((other, k) => ({ gap: gapOf(one, other), i, j: i + 1 + k })));
    const { gap, i, j } = pairs.reduce((a, b) => (b.gap < a.gap ? b : a));
    if (gap >= 1) break;
    groups[i] = [...groups[i], ...groups[j]];
    groups.splice(j, 1);
  }
  const masses = groups.map((group) => momentsOf(group, best).mass);
  const total = masses.reduce((sum, mass) => sum + mass, 0);
  const places = groups.map((group, k) => placeOf(group, masses[k] / total));
  return places.filter(({ share }) => share >= LEAST_SHARE).sort((a, b) => b.share - a.share);
}

/** @param {Tile[]} tiles */
const leastOf = (tiles) => tiles.reduce((least, { costs }) => costs.reduce((a, b) => Math.min(a, b), least), Infinity);

/** @param {Cell[]} cells */
const bestOf = (cells) => cells.reduce((least, cell) => Math.min(least, cell[4]), Infinity);

/** @param {Box[]} boxes */
const ground = (boxes) => boxes.reduce((sum, box) => sum + box[2] * box[3], 0);

/** The boxes of what is left in each square of so many cells a side, a quarter more about it. @param {Tile} tile @param {number} least @param {number} side */
function cuts({ box, costs }, least, side) {
  /** @type {Box[]} */
  const found = [];
  for (let row = 0; row < CELLS; row += side) {
    for (let column = 0; column < CELLS; column += side) {
      const outline = outlineOf(costs, least, row, column, side);
      if (!outline) continue;
      const [top, bottom, left, right] = outline;
      const [size_x, size_y] = [((right - left) * box[2]) / CELLS, ((bottom - top) * box[3]) / CELLS];
      found.push([box[0] + (column + left) * box[2], box[1] + (row + top) * box[3], size_x, size_y]);
    }
  }
  return found;
}

/** The first row and column that is left within a square, and those after the last. @param {Float64Array} costs @param {number} least @param {number} row @param {number} column @param {number} side */
function outlineOf(costs, least, row, column, side) {
  let [top, bottom, left, right] = [side, -1, side, -1];
  for (let r = 0; r < side; r += 1) {
    for (let c = 0; c < side; c += 1) {
      if (costs[(row + r) * CELLS + column + c] >= least + KEPT) continue;
      [top, bottom, left, right] = [Math.min(top, r), Math.max(bottom, r), Math.min(left, c), Math.max(right, c)];
    }
  }
  if (bottom < 0) return null;
  const [above, aside] = [1 + Math.floor((bottom - top) / 4), 1 + Math.floor((right - left) / 4)];
  return [Math.max(0, top - above), Math.min(side, bottom + above + 1), Math.max(0, left - aside), Math.min(side, right + aside + 1)];
}

/** @param {Tile} tile @param {number} least */
function cellsOf({ box, costs }, least) {
  /** @type {Cell[]} */
  const cells = [];
  costs.forEach((cost, at) => {
    if (cost >= least + KEPT) return;
    cells.push([box[0] + ((at % CELLS) + 0.5) * box[2], box[1] + (Math.floor(at / CELLS) + 0.5) * box[3], box[2], box[3], cost]);
  });
  return cells;
}

/** @param {Cell} cell @param {number} best */
const massOf = ([, , wide, high, cost], best) => Math.exp(-0.5 * (cost - best)) * wide * high;

/** Mean, covariance and mass of cells, as a share of the best density in square metres. @param {Cell[]} cells @param {number} best @returns {Moments} */
function momentsOf(cells, best) {
  let [mass, x, y] = [0, 0, 0];
  for (const cell of cells) {
    const own = massOf(cell, best);
    [mass, x, y] = [mass + own, x + own * cell[0], y + own * cell[1]];
  }
  [x, y] = [x / mass, y / mass];
  let [xx, xy, yy] = [0, 0, 0];
  for (const cell of cells) {
    const [own, dx, dy] = [massOf(cell, best), cell[0] - x, cell[1] - y];
    [xx, xy, yy] = [xx + own * (dx * dx + cell[2] ** 2 / 12), xy + own * dx * dy, yy + own * (dy * dy + cell[3] ** 2 / 12)];
  }
  return { x, y, xx: xx / mass, xy: xy / mass, yy: yy / mass, mass };
}

/** Both sides of where cells fall apart best along their longest axis (Otsu 1979). @param {Cell[]} cells */
function halves(cells) {
  const best = bestOf(cells);
  const { x, y, xx, xy, yy } = momentsOf(cells, best);
  const angle = 0.5 * Math.atan2(2 * xy, xx - yy);
  const along = cells.map((cell) => (cell[0] - x) * Math.cos(angle) + (cell[1] - y) * Math.sin(angle));
  const low = along.reduce((a, b) => Math.min(a, b), Infinity);
  const high = along.reduce((a, b) => Math.max(a, b), -Infinity);
  if (high - low <= 0) return [cells];
  const bins = along.map((value) => Math.min(Math.trunc(((value - low) / (high - low)) * BINS), BINS - 1));
  const [masses, sums] = [new Float64Array(BINS), new Float64Array(BINS)];
  cells.forEach((cell, k) => {
    const own = massOf(cell, best);
    masses[bins[k]] += own;
    sums[bins[k]] += own * along[k];
  });
  const [mass, sum] = [masses.reduce((a, b) => a + b, 0), sums.reduce((a, b) => a + b, 0)];
  let [left, leftSum, most, last] = [0, 0, -1, 0];
  for (let bin = 0; bin < BINS - 1; bin += 1) {
    [left, leftSum] = [left + masses[bin], leftSum + sums[bin]];
    const apart = left * (mass - left) * (leftSum / left - (sum - leftSum) / (mass - left)) ** 2;
    if (apart > most) [most, last] = [apart, bin];
  }
  return [cells.filter((_, k) => bins[k] <= last), cells.filter((_, k) => bins[k] > last)];
}

/** How far apart two pieces are, as a share of what makes them two. @param {Cell[]} one @param {Cell[]} other */
function gapOf(one, other) {
  const [a, b] = [one, other].map((cells) => momentsOf(cells, bestOf(cells)));
  const far = Math.hypot(b.x - a.x, b.y - a.y);
  if (far === 0) return 0;
  const [u, v] = [(b.x - a.x) / far, (b.y - a.y) / far];
  const sd = (/** @type {Moments} */ { xx, xy, yy }) => Math.sqrt(u * u * xx + 2 * u * v * xy + v * v * yy);
  return far / (APART_SD * (sd(a) + sd(b)));
}

/** @param {Cell[]} cells @param {number} share @returns {Spot} */
function placeOf(cells, share) {
  const best = bestOf(cells);
  const { x, y, xx, xy, yy } = momentsOf(cells, best);
  const off = (/** @type {Cell} */ cell) => Math.max(Math.abs(cell[0] - x) / cell[2], Math.abs(cell[1] - y) / cell[3]);
  const nearest = cells.reduce((a, b) => (off(b) < off(a) ? b : a));
  const is_hollow = off(nearest) > 1 || Math.exp(-0.5 * (nearest[4] - best)) < HOLLOW;
  return { x_m: x, y_m: y, var_x: xx, var_xy: xy, var_y: yy, share, is_hollow };
}
