/** Help and orders that concern everybody: MAYDAY, and EVACUATE. */

import { HoldButton } from "../console/hold_button.js";
import { html } from "../console/vendor.js";
import { add, waiting } from "./outbox.js";
import { missions } from "./pockets.js";
import { missionPath, reach, read, remember } from "./reach.js";
import { changed, missionId, state } from "./state.js";
import { say } from "./texts.js";

const LOOK_EVERY_MS = 5000;
const HEARD = "waymark.heard";

/** The mission of this phone, also where it is at no tag now. */
const here = () => missionId() || (missions()[0]?.mission_id ?? "");

async function callMayday() {
  await add("mayday", here(), { text: "", tag_id: state.tagId || null });
  changed({ called: true });
}

/** Look for EVACUATE now and every few seconds; what is shown stays while the server does not answer. */
export async function lookForOrders() {
  const mission = here();
  if (mission && document.visibilityState === "visible") {
    const found = await read(`${missionPath(mission)}/evacuation`);
    if (found) changed({ evacuation: found.ordered ? found : null });
  }
  setTimeout(lookForOrders, LOOK_EVERY_MS);
}

/** Which order was heard here: another one has to be heard again. */
const heardHere = () => Number(localStorage.getItem(HEARD));

async function hear() {
  const since_unix_s = state.evacuation?.since_unix_s ?? 0;
  remember(HEARD, since_unix_s);
  await add("heard", here(), { since_unix_s });
  changed();
}

export function Alarm() {
  const { evacuation } = state;
  if (!evacuation) return null;
  const isSent = evacuation.acknowledged.some(({ name }) => name === reach.me?.name);
  const isHeard = isSent || heardHere() === evacuation.since_unix_s;
  return html`<div class="alarm" role="alert"><span>${say("evacuate", { by: evacuation.by })}</span>
    ${!isHeard && html`<button type="button" onClick=${hear}>${say("i_have_heard")}</button>`}
    ${isHeard && waiting().some(({ kind }) => kind === "heard") && html`<span>${say("heard_waits")}</span>`}</div>`;
}

export function Mayday() {
  if (!here()) return null;
  if (waiting().some(({ kind }) => kind === "mayday")) return html`<p class="alarm" role="alert">${say("mayday_waits")}</p>`;
  if (state.called) return html`<p role="status"><b>${say("mayday_called")}</b></p>`;
  return html`<${HoldButton} label=${say("mayday_hold")} name=${say("mayday_hold")} kind="mayday" onFire=${callMayday} />`;
}
