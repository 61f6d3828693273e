/** Reports that wait for the server: kept until it has said that it has them, sent the most important first, MAYDAY by itself. */

import { newId } from "../console/note_kinds.js";
import { all, drop, put } from "./kept.js";
import { asOf, ask, askWho, missionPath, onReach, reach, reasonOf } from "./reach.js";
import { keepSent } from "./sent.js";

/** `n`: in which order they were made; `is_carried`: taken over from another phone; `refused`: why the server will not have it,
 * `is_for_now` until somebody else logs in.
 * @typedef {{id: string, n: number, mission_id: string, kind: string, body: Record<string, any>, made_by: string,
 *   is_carried?: boolean, phone_unix_s: number, offset_s: number | null, tries: number, due_ms: number, refused: string, is_for_now?: boolean, is_kept: boolean}} Report */

const FIRST_MS = 1000;
const LOOK_EVERY_MS = 60_000;
const PHOTO_MS = 120_000; // of 300 kB over a bad link
const REFUSALS = [403, 404, 409, 413, 415, 422];
/** @type {Record<string, number>} */
const URGENCY = { mayday: 0, heard: 1, victim: 2, hazard: 3, note: 4, searched: 4, exit: 4, photo: 5, at: 6 };

/** @type {Map<string, Report>} */
const reports = new Map();
/** @type {(() => void)[]} */
const watchers = [];
/** A sender each, so that no photo stands before a word, and neither they nor a storage that is slow before a call for help. */
const LANES = [
  { of: "mayday", isSending: false, timer: 0, longest_ms: 4000 },
  { of: "word", isSending: false, timer: 0, longest_ms: 60_000 },
  { of: "photo", isSending: false, timer: 0, longest_ms: 60_000 },
];
/** @typedef {typeof LANES[0]} Lane */

/** @param {() => void} watch called when a report was added, sent or refused */
export function onOutbox(watch) {
  watchers.push(watch);
}

const changed = () => watchers.forEach((watch) => watch());

/** @param {Report} report */
const urgencyOf = ({ kind, body }) => URGENCY[kind === "note" ? body.note : kind] ?? 9;

/** Reports of this phone that the server does not have, the most important first. @returns {Report[]} */
export const waiting = () => [...reports.values()].sort((a, b) => urgencyOf(a) - urgencyOf(b) || a.n - b.n);

/** Whether reports are lost when the page is closed, because the phone's storage is full. */
export const isFull = () => [...reports.values()].some(({ is_kept }) => !is_kept);

/** Read what waits from an earlier time, and begin to send. */
export async function openOutbox() {
  await sendNow();
  addEventListener("online", () => sendNow());
  document.addEventListener("visibilitychange", () => document.visibilityState === "visible" && sendNow());
  let was = reach.inReach;
  onReach(() => {
    if (reach.inReach && !was) sendNow();
    if (reach.inReach && !was && !reach.me) askWho(); // what is written has to be signed
    was = reach.inReach;
  });
  setInterval(() => sendNow(), LOOK_EVERY_MS);
}

/**
 * Take a report: it is on the phone when this returns, or in its memory where the storage is full.
 * @param {string} kind
 * @param {string} missionId
 * @param {Record<string, any>} body
 * @param {number} [made_s] when it was made, by this phone's clock
 */
export async function add(kind, missionId, body, made_s = Date.now() / 1000) {
  const n = Math.max(0, ...[...reports.values()].map((report) => report.n)) + 1;
  /** @type {Report} */
  const report = { id: newId(), n, mission_id: missionId, kind, body, made_by: reach.me?.name ?? "", phone_unix_s: made_s,
    offset_s: reach.offset_s, tries: 0, due_ms: 0, refused: "", is_kept: true };
  if (kind === "at") { // only the last place counts, and what cannot be
    for (const old of reports.values()) {
      if (old.kind === "at" && !old.body.from_tag && old.mission_id === missionId && old.made_by === report.made_by) await forget(old.id);
    }
  }
  reports.set(report.id, report);
  const kept = keep(report);
  if (kind === "mayday") flush();
  await kept;
  changed();
  flush();
  return report;
}

/** Take over what another phone could not send; sent by both it counts once. @param {Report[]} others */
export async function adopt(others) {
  for (const report of others) {
    if (reports.has(report.id)) continue;
    report.n = Math.max(0, ...[...reports.values()].map(({ n }) => n)) + 1;
    reports.set(report.id, report);
    await keep(report);
  }
  changed();
  flush();
}

/** @param {Report} report */
async function keep(report) {
  report.is_kept = await put("outbox", { ...report, is_kept: true }).then(() => true, () => false);
}

/** Let go of a report: the server has it, or its writer does not want it any more. @param {string} id */
export async function forget(id) {
  reports.delete(id);
  await drop("outbox", id).catch(() => undefined);
}

/**
 * Try everything now, also what another page of this phone left when it was closed.
 * @param {boolean} [isAgain] also what the server has refused
 */
export async function sendNow(isAgain = false) {
  for (const report of await all("outbox").catch(() => [])) if (!reports.has(report.id)) reports.set(report.id, report);
  changed();
  for (const report of reports.values()) Object.assign(report, { due_ms: 0, refused: isAgain || report.is_for_now ? "" : report.refused });
  return flush();
}

const flush = () => Promise.all(LANES.map(flushLane));

/** @param {Lane} lane */
async function flushLane(lane) {
  if (lane.isSending) return;
  lane.isSending = true;
  clearTimeout(lane.timer);
  try {
    for (let report = due(lane); report; report = due(lane)) if (!(await send(report, lane.longest_ms))) break;
  } finally {
    lane.isSending = false;
  }
  for (const report of of(lane)) if (!report.is_kept) await keep(report);
  changed();
  const next = Math.min(...of(lane).filter(({ refused }) => !refused).map(({ due_ms }) => due_ms));
  if (next < Infinity) lane.timer = setTimeout(() => flushLane(lane), Math.max(50, next - Date.now()));
}

/** @param {Lane} lane */
const of = (lane) => waiting().filter(({ kind }) => (kind === "mayday" || kind === "photo" ? kind : "word") === lane.of);

/** @param {Lane} lane */
const due = (lane) => of(lane).find(({ refused, due_ms }) => !refused && due_ms <= Date.now());

/** @param {Report} report */
function request(report) {
  const { id, kind, body, made_by, is_carried = false, phone_unix_s, offset_s } = report;
  const path = missionPath(report.mission_id);
  if (kind === "photo") {
    const { picture, tag_id, text } = body;
    const query = new URLSearchParams({ photo_id: id, tag_id, text, taken_unix_s: String(phone_unix_s + (offset_s ?? 0)) });
    return ask("POST", `${path}/photos?${query}`, { headers: { "Content-Type": picture.type }, body: picture }, PHOTO_MS);
  }
  const words = { ...body, kind, made_by, is_carried, phone_unix_s, offset_s, sent_phone_unix_s: Date.now() / 1000 };
  return ask("PUT", `${path}/reports/${id}`, { headers: { "Content-Type": "application/json" }, body: JSON.stringify(words) });
}

/** @param {Report} report @param {number} longest_ms between two tries @returns {Promise<boolean>} whether it makes sense to go on with the next */
async function send(report, longest_ms) {
  const response = await request(report);
  const isHelp = report.kind === "mayday"; // what is written meanwhile is not waited for
  if (response?.ok) {
    keepSent(report, asOf(response));
    const gone = forget(report.id);
    changed();
    if (!isHelp) await gone;
    return true;
  }
  if (response && REFUSALS.includes(response.status)) {
    report.refused = await reasonOf(response);
    report.is_for_now = response.status === 403;
    const kept = keep(report);
    if (!isHelp) await kept;
    return true;
  }
  report.tries += 1;
  report.due_ms = Date.now() + Math.min(longest_ms, FIRST_MS * 2 ** Math.min(report.tries - 1, 10)) * (0.5 + Math.random());
  return false;
}
