/** EVACUATE, mission by mission, as the server said last: it stays, over reloads and without signal, until the server says that it is over. */

import { remember, remembered } from "./reach.js";

/** @import {Evacuation} from "./types.js" */
/** `over_s`: since when the latest order held that is over. @typedef {{order: Evacuation | null, over_s: number}} Kept */

const ORDERS = "waymark.orders";

/** @returns {Record<string, Kept>} */
const kept = () => remembered(ORDERS) ?? {};

/** A mission that is carried says that it holds; it may be too old to say that it does not. @param {string} mission @param {Evacuation | null} order */
export function takeOrder(mission, order) {
  const { order: known = null, over_s = 0 } = kept()[mission] ?? {};
  if (!order?.ordered || order.since_unix_s <= over_s || order.since_unix_s < (known?.since_unix_s ?? 0)) return;
  remember(ORDERS, { ...kept(), [mission]: { order, over_s } });
}

/** What the server itself says now. @param {string} mission @param {Evacuation} found */
export function takeAnswer(mission, found) {
  if (found.ordered) return takeOrder(mission, found);
  const { order = null } = kept()[mission] ?? {};
  if (order) remember(ORDERS, { ...kept(), [mission]: { order: null, over_s: order.since_unix_s } });
}

/** The latest order that holds in any of these missions. @param {string[]} missions @returns {(Evacuation & {mission: string}) | null} */
export function orderIn(missions) {
  const orders = missions.map((mission) => ({ mission, order: kept()[mission]?.order ?? null }));
  const [latest] = orders.sort((a, b) => (b.order?.since_unix_s ?? 0) - (a.order?.since_unix_s ?? 0));
  return latest?.order ? { ...latest.order, mission: latest.mission } : null;
}
