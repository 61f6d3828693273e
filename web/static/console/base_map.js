/** What was there before the mission and lies under its map: what it is, and taking changes of it back. */

import { missionPath, request } from "./api.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */

const SUBJECT = "the base map";

/** The newest change that stands; each one taken back cancels one before it. @param {{action: string, subject: string, audit_id: number}[]} entries newest first */
function lastChange(entries) {
  let gone = 0;
  for (const entry of entries.filter(({ subject }) => subject === SUBJECT)) {
    if (entry.action === "take_back") gone += 1;
    else if (gone > 0) gone -= 1;
    else return entry;
  }
  return null;
}

/** @param {Store} store */
async function takeBack(store) {
  const path = `${missionPath(store.missionId ?? "")}/audit`;
  try {
    const entry = lastChange((await request("GET", `${path}?limit=1000`)).entries);
    if (entry) await request("POST", `${path}/${entry.audit_id}/undo`);
    else store.notify("Nobody has changed what lies under the map.");
  } catch (error) {
    store.notify(`What lies under the map stays. ${/** @type {Error} */ (error).message}`);
  }
}

/** @param {Store} store */
async function remove(store) {
  try {
    await request("DELETE", `${missionPath(store.missionId ?? "")}/base-map`);
  } catch (error) {
    store.notify(`The base map stays. ${/** @type {Error} */ (error).message}`);
  }
}

/** @param {{store: Store}} props */
export function BaseMapLines({ store }) {
  const base = store.live.baseMap;
  return html`<p class="hint-line">${base ? `Under the map: ${base.source}, laid by ${base.by}.` : "No plan lies under the map."}</p>
    ${base && html`<button type="button" onClick=${() => remove(store)}>Take the base map away</button>`}
    <button type="button" onClick=${() => takeBack(store)}>Take back its last change</button>`;
}
