/** EVACUATE: the order to leave, who has heard it, and how it is given and taken back. */

import { missionPath, request } from "./api.js";
import { age } from "./format.js";
import { HoldButton } from "./hold_button.js";
import { html } from "./vendor.js";

/** @import {Store} from "./store.js" */

/** @param {Store} store @param {"POST" | "DELETE"} method @param {string} [path] */
async function order(store, method, path = "") {
  try {
    await request(method, `${missionPath(store.missionId ?? "")}/evacuation${path}`);
  } catch (error) {
    store.notify(`EVACUATE: ${/** @type {Error} */ (error).message}`, "alarm");
  }
}

/** In the bar over everything. @param {{store: Store}} props */
export function EvacuateButton({ store }) {
  if (!store.missionId || store.live.evacuation) return null;
  return html`<${HoldButton} label="EVACUATE" name="EVACUATE: order everybody out" kind="evacuate"
    onFire=${() => order(store, "POST")} />`;
}

/** Across the page while it holds. @param {{store: Store}} props */
export function EvacuationBanner({ store }) {
  const { evacuation, people } = store.live;
  if (!evacuation) return null;
  const heard = evacuation.acknowledged.map(({ name }) => name);
  const missing = [...people.keys()].filter((name) => !heard.includes(name));
  const mine = !store.me || heard.includes(store.me.name);
  return html`<div class="evacuation" role="alert">
    <strong>EVACUATE</strong>
    <span>Everybody out, says ${evacuation.by}, ${age(Math.max(0, store.serverNow() - evacuation.since_unix_s))}.
      ${heard.length ? ` Heard by ${heard.join(", ")}.` : " Nobody has said yet that they heard it."}
      ${missing.length > 0 && html` <b>Not yet: ${missing.join(", ")}.</b>`}</span>
    ${!mine && html`<button type="button" class="heard" onClick=${() => order(store, "POST", "/acknowledge")}>I have heard it</button>`}
    <${HoldButton} label="It is over" name="EVACUATE is over" kind="calm" onFire=${() => order(store, "DELETE")} /></div>`;
}
