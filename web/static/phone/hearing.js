/** From the signals that a phone hears to how far off nodes sound, as robots/estimation/radio/hearing.py. */

/** @import {Heard} from "./locating.js" */
/** @import {Shared} from "./likelihood.js" */
/** @import {Pocket, PocketTag, Radio} from "./types.js" */

const NEAREST_M = 0.05;
const FITS_SD = 2.5;
const LEAST_SD = 1e-3;

/** What all signals have in common, in ln d. @param {Radio} radio @returns {Shared} */
export function sharedOf({ path_loss_exponent, gain_sd_db, exponent_sd, wall_db, reach_m, distances_m, sds_db }) {
  const perDb = Math.LN10 / (10 * path_loss_exponent);
  return { gain_sd: gain_sd_db * perDb, wall: wall_db * perDb, reach_m, exponent_sd, distances_m, shadow_sds: sds_db.map((sd) => sd * perDb) };
}

/** How far off nodes sound; those that are not on the map, and those whose signals do not agree, are left out.
 * @param {Pocket} pocket @param {Map<string, number[]>} signals dBm by node @returns {{heard: Heard[], unknown: string[]}} */
export function heardOf(pocket, signals) {
  const tags = new Map(pocket.tags.map((tag) => [tag.tag_id, tag]));
  const unknown = [...signals.keys()].filter((id) => !tags.has(id)).sort();
  /** @type {Heard[]} */
  const heard = [];
  for (const [id, rssis] of signals) {
    const one = tags.has(id) ? bySignal(pocket.radio, /** @type {PocketTag} */ (tags.get(id)), rssis) : null;
    if (one) heard.push(one);
  }
  return { heard, unknown };
}

/** @param {Radio} radio @param {PocketTag} tag @param {number[]} rssis @returns {Heard | null} */
function bySignal(radio, tag, rssis) {
  const mean = robustMean(rssis.filter(Number.isFinite), radio.fading_sd_db);
  if (!mean) return null;
  const decades = (radio.power_at_1m_dbm - mean.rssi) / (10 * radio.path_loss_exponent);
  const fading = ((Math.LN10 / (10 * radio.path_loss_exponent)) * radio.fading_sd_db) / Math.sqrt(mean.count);
  const log_sd = Math.max(fading, LEAST_SD);
  const range_m = Math.max(10 ** Math.min(decades, 6), NEAREST_M);
  return { node_id: tag.tag_id, x_m: tag.x_m, y_m: tag.y_m, place_sd_m: tag.sd_m / Math.SQRT2, range_m, log_sd, sd_m: 0 };
}

/** The mean of the readings that agree, null where no two and no half of them do. @param {number[]} rssis @param {number} fading_sd_db */
export function robustMean(rssis, fading_sd_db) {
  if (rssis.length < 2) return rssis.length ? { rssi: rssis[0], count: 1 } : null;
  const values = [...rssis].sort((a, b) => a - b);
  const close = Math.max(FITS_SD * Math.sqrt(1.5) * fading_sd_db, 1e-6);
  let best = { count: 0, off: Infinity, sum: 0 };
  for (let i = 0; i < values.length; i += 1) {
    for (let j = i + 1; j < values.length; j += 1) {
      const start = (values[i] + values[j]) / 2;
      const fits = values.filter((value) => Math.abs(value - start) <= close);
      const off = fits.reduce((sum, value) => sum + Math.abs(value - start), 0);
      if (fits.length < best.count || (fits.length === best.count && off >= best.off)) continue;
      best = { count: fits.length, off, sum: fits.reduce((sum, value) => sum + value, 0) };
    }
  }
  return best.count < 2 || 2 * best.count < values.length ? null : { rssi: best.sum / best.count, count: best.count };
}
