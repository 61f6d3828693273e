/** Notes that the server has, but the mission on this phone has not yet: they stay in sight until it has. */

import { remember, remembered } from "./reach.js";

/** @import {Report} from "./outbox.js" */
/** @import {Pocket} from "./types.js" */

const SENT = "waymark.sent";
const MOST = 50;

/** `taken_s`: when the server had it, by its own clock. @type {(Report & {taken_s: number})[]} */
let sent = remembered(SENT) ?? [];

/** @param {(Report & {taken_s: number})[]} reports */
function keep(reports) {
  sent = reports.slice(-MOST);
  remember(SENT, sent);
}

/** The server has taken a report. @param {Report} report @param {number} taken_s by its clock */
export function keepSent(report, taken_s) {
  if (report.kind === "note") keep([...sent.filter(({ id }) => id !== report.id), { ...report, taken_s }]);
}

/**
 * What the server has taken of a mission's notes and the phone's copy lacks. A copy of later that lacks one: it was taken off again.
 * @param {Pocket} pocket @param {number} as_of_s of when it is, by the server's clock
 * @returns {Report[]}
 */
export function sentBeyond(pocket, as_of_s) {
  const known = new Set(pocket.notes.map(({ annotation_id }) => annotation_id));
  const still = sent.filter(({ id, mission_id, taken_s }) => mission_id !== pocket.mission_id || (!known.has(id) && as_of_s <= taken_s));
  if (still.length < sent.length) keep(still);
  return sent.filter(({ mission_id }) => mission_id === pocket.mission_id);
}
