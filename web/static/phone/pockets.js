/** The missions on this phone: which one a tag belongs to, and getting the newest of each while the server is in reach. */

import { byLikelihood, isParsed, missionsWith, pocketOf } from "./carried.js";
import { all, drop, put } from "./kept.js";
import { asOf, ask, missionPath, read } from "./reach.js";

/** @import {Pocket} from "./types.js" */
/** @import {Kept} from "./carried.js" */

const MOST = 4; // missions on a phone
const OVER = ["closed", "archived"];

/** @type {Map<string, Kept>} */
const kept = new Map();
/** @type {string[] | null} */
let goingOn = null;
export const pockets = { isFull: false };

/** What the phone has. A storage that cannot be read is an empty one. */
export const opened = all("pockets").catch(() => []).then((items) => {
  for (const item of items) kept.set(item.mission_id, item);
});

/** Missions that may be meant, first the one that is most likely: running, then the latest. */
export function missions() {
  return [...kept.values()].sort(byLikelihood);
}

/**
 * The mission that a tag is of.
 * @param {string} tagId
 * @param {string | null} missionId only this one, if told
 * @param {string} own the one that this phone is in, which is meant before all others unless it is over
 * @returns {Kept | null}
 */
export function missionOf(tagId, missionId, own) {
  const able = missionsWith([...kept.values()], tagId, missionId);
  return able.find(({ mission_id }) => mission_id === own && !isOver(own)) ?? able[0] ?? null;
}

/** @param {string} missionId */
export const keptOf = (missionId) => kept.get(missionId) ?? null;

/** @typedef {"same" | "new" | "failed"} Outcome */

/** What is being fetched: over a slow network nothing is fetched twice at a time. @type {Map<string, Promise<Outcome>>} */
const underWay = new Map();

/** Get the newest of a mission. @param {string} missionId @returns {Promise<Outcome>} */
export function refresh(missionId) {
  const coming = underWay.get(missionId) ?? newest(missionId).finally(() => underWay.delete(missionId));
  underWay.set(missionId, coming);
  return coming;
}

/** @param {string} missionId @returns {Promise<Outcome>} */
async function newest(missionId) {
  await opened;
  const known = kept.get(missionId);
  const headers = known ? { "If-None-Match": known.etag } : undefined;
  const have = Object.values(known?.parts ?? {}).join(); // what has not changed is not sent again
  const response = await ask("GET", `${missionPath(missionId)}/pocket?have=${have}`, { headers });
  if (response?.status === 304 && known) {
    await keep({ ...known, as_of_s: asOf(response) });
    return "same";
  }
  if (!response?.ok) return "failed";
  try {
    const told = await response.json();
    /** @type {Pocket} */
    const pocket = { ...(known && pocketOf(known)), ...told };
    const text = JSON.stringify(pocket);
    isParsed(text, pocket);
    const { mission_id, mission_name, state, created_unix_s, parts, tags } = pocket;
    await keep({ mission_id, mission_name, state, created_unix_s, etag: response.headers.get("ETag") ?? "", parts, text, as_of_s: asOf(response),
      tag_ids: tags.map(({ tag_id }) => tag_id) });
    return "new";
  } catch {
    return "failed"; // it broke off on the way: what was there stays
  }
}

/** Get all missions that are not over, those that run first, so that any of their tags is known here later. */
export async function refreshAll() {
  const found = await read("/missions");
  if (!found) return;
  /** @type {{mission_id: string, state: string, created_unix_s: number}[]} */
  const going = found.missions.filter((/** @type {{state: string}} */ { state }) => !OVER.includes(state));
  going.sort(byLikelihood);
  goingOn = going.map(({ mission_id }) => mission_id);
  for (const { mission_id } of going.slice(0, MOST)) await refresh(mission_id);
}

/** Whether a mission is over, as far as this phone knows. @param {string} missionId */
export const isOver = (missionId) => OVER.includes(kept.get(missionId)?.state ?? "");

/** All missions that are not over, as far as this phone knows: by the server's list, before any of them is here. */
export const going = () => goingOn ?? missions().map(({ mission_id }) => mission_id).filter((id) => !isOver(id));

/** @param {Kept} item */
async function keep(item) {
  kept.set(item.mission_id, item);
  for (const old of missions().slice(MOST)) {
    if (old.mission_id === item.mission_id) continue;
    kept.delete(old.mission_id);
    await drop("pockets", old.mission_id).catch(() => undefined);
  }
  await put("pockets", item).then(() => (pockets.isFull = false), () => (pockets.isFull = true));
}
