/** The victims of the mission in the order in which they need somebody, and saying something about one. */

import { missionPath, request } from "./api.js";

/** @import {Victim} from "./types.js" */
/** @import {Store} from "./store.js" */

/** Victims that still need somebody first. */
const URGENCY = ["suspected", "confirmed", "reached", "extricated", "dismissed"];

/** Victims that stand for themselves, unseen ones first, then by urgency, then by confidence. @param {Store} store */
export function standing(store) {
  return [...store.victims.values()].filter(({ merged_into }) => !merged_into).sort((a, b) =>
    Number(a.by !== "") - Number(b.by !== "") || URGENCY.indexOf(a.status) - URGENCY.indexOf(b.status)
    || b.confidence - a.confidence || a.victim_id.localeCompare(b.victim_id));
}

/**
 * Say something about a victim; what goes wrong is shown.
 * @param {Store} store
 * @param {Victim} victim
 * @param {Record<string, unknown>} words
 */
export async function say(store, victim, words) {
  const path = `${missionPath(store.missionId ?? "")}/victims/${encodeURIComponent(victim.victim_id)}`;
  try {
    await request("PATCH", path, words);
  } catch (error) {
    store.notify(`Victim ${victim.victim_id} was not changed. ${/** @type {Error} */ (error).message}`);
  }
  store.changed();
}
