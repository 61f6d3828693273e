/** Notes that the server has, but the mission on this phone has not yet: they stay in sight until it has. */

import { now_s, remember, remembered } from "./reach.js";

/** @import {Report} from "./outbox.js" */
/** @import {Pocket} from "./types.js" */

const SENT = "waymark.sent";
const MOST = 50;
const PACKED_S = 5; // what the server sends of a mission may be a second old, and clocks are learnt to a second

/** @type {(Report & {sent_s: number})[]} */
let sent = remembered(SENT) ?? [];

/** @param {(Report & {sent_s: number})[]} reports */
function keep(reports) {
  sent = reports.slice(-MOST);
  remember(SENT, sent);
}

/** The server has taken a report. @param {Report} report */
export function keepSent(report) {
  if (report.kind === "note") keep([...sent.filter(({ id }) => id !== report.id), { ...report, sent_s: now_s() }]);
}

/**
 * What the server has taken of a mission's notes and the phone's copy lacks. A copy of later that lacks one: it was taken off again.
 * @param {Pocket} pocket @param {number} as_of_s when the server said that this is the latest, by its own clock
 * @returns {Report[]}
 */
export function sentBeyond(pocket, as_of_s) {
  const known = new Set(pocket.notes.map(({ annotation_id }) => annotation_id));
  const still = sent.filter(({ id, mission_id, sent_s }) => mission_id !== pocket.mission_id || (!known.has(id) && as_of_s <= sent_s + PACKED_S));
  if (still.length < sent.length) keep(still);
  return sent.filter(({ mission_id }) => mission_id === pocket.mission_id);
}
