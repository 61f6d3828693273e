/** Whether this phone can have come from the tag it read last to this one, as robots/routes/pace.py: else one of them is a copy, or was moved. */

import { state } from "./state.js";

/** @import {PocketTag} from "./types.js" */
/** A tag that was read, when by this phone's clock, and by how much that was known to be slow, s.
 *  @typedef {{mission: string, tag: string, phone_s: number, offset_s: number | null}} Seen */
/** @typedef {{tag: string, before: string, far_m: number, after_s: number}} TooFar */

const FASTEST_MPS = 5;
const LATE_S = 2;
const SDS = 3;
const MOST = 3;
const LONGEST_S = 3600;

/** @param {number} straight_m @param {number} sd_m @param {number} after_s */
export const isTooFar = (straight_m, sd_m, after_s) => after_s >= 0 && straight_m - SDS * sd_m > FASTEST_MPS * (after_s + LATE_S);

/**
 * How long after one tag another was read: by the clock, or by what was known of it if that is longer, as it may have been
 * set meanwhile; less than nothing where it was set back.
 * @param {Seen} from @param {Seen} to
 */
export function between(from, to) {
  const plain_s = to.phone_s - from.phone_s;
  if (from.offset_s === null || to.offset_s === null) return plain_s;
  const known_s = plain_s + to.offset_s - from.offset_s;
  return plain_s < 0 || known_s < 0 ? Math.min(plain_s, known_s) : Math.max(plain_s, known_s);
}

/**
 * Judge a tag that was read by those read before it.
 * @param {Seen[]} earlier the tag before it, or those of which one must be a copy
 * @param {Seen} now
 * @returns {{odd: TooFar | null, seen: Seen[]}} what does not fit, and what the next tag is judged by
 */
export function judged(earlier, now) {
  const tags = /** @param {Seen} seen */ ({ tag }) => state.roads?.tags[state.roads.numbers.get(tag) ?? -1];
  const here = tags(now);
  const known = earlier.filter(({ mission, tag }) => mission === now.mission && tag !== now.tag);
  if (!here || here.notice || !known.length) return { odd: null, seen: [now] };
  const far = known.map((from) => tooFar(from, now, tags(from), here));
  const odd = far.every((found) => found !== null) ? far[0] : null;
  return { odd, seen: odd ? [...known, now].slice(-MOST) : [now] };
}

/**
 * The tag that the phone's owner walked from; null where that is not certain, or too long ago to be a way.
 * @param {Seen[]} earlier @param {Seen} now
 */
export function cameFrom(earlier, now) {
  const [from, ...others] = earlier.filter(({ mission }) => mission === now.mission);
  if (!from || others.length || from.tag === now.tag) return null;
  const after_s = Math.round(10 * between(from, now)) / 10;
  return after_s >= 0 && after_s <= LONGEST_S ? { from_tag: from.tag, after_s } : null;
}

/** @param {Seen} from @param {Seen} to @param {PocketTag | undefined} start @param {PocketTag} end @returns {TooFar | null} */
function tooFar(from, to, start, end) {
  if (!start || start.notice) return null;
  const far_m = Math.hypot(end.x_m - start.x_m, end.y_m - start.y_m);
  const after_s = between(from, to);
  return isTooFar(far_m, Math.hypot(start.sd_m, end.sd_m), after_s) ? { tag: to.tag, before: from.tag, far_m, after_s } : null;
}
