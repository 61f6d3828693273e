/** Help and orders that concern everybody: MAYDAY, and EVACUATE. */

import { missionPath, request } from "../console/api.js";
import { HoldButton } from "../console/hold_button.js";
import { html } from "../console/vendor.js";
import { wordsOf } from "./lead.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";

const LOOK_EVERY_MS = 5000;

const evacuationPath = () => `${missionPath(state.where?.mission_id ?? "")}/evacuation`;

async function callMayday() {
  try {
    await request("POST", `${missionPath(state.where?.mission_id ?? "")}/alerts/mayday`, { text: "", tag_id: state.tagId });
    changed({ called: true, trouble: "" });
  } catch (error) {
    changed({ trouble: say("mayday_not_sent", { why: wordsOf(error) }) });
  }
}

/** Look for EVACUATE now and every few seconds; what is shown stays while the server does not answer. */
export async function lookForOrders() {
  if (state.where) {
    const found = await request("GET", evacuationPath()).catch(() => null);
    if (found) changed({ evacuation: found.ordered ? found : null });
  }
  setTimeout(lookForOrders, LOOK_EVERY_MS);
}

async function heard() {
  changed({ evacuation: await request("POST", `${evacuationPath()}/acknowledge`).catch(() => state.evacuation) });
}

export function Alarm() {
  const { evacuation, me } = state;
  if (!evacuation) return null;
  const isHeard = evacuation.acknowledged.some(({ name }) => name === me?.name);
  return html`<div class="alarm" role="alert"><span>${say("evacuate", { by: evacuation.by })}</span>
    ${!isHeard && html`<button type="button" onClick=${heard}>${say("i_have_heard")}</button>`}</div>`;
}

export function Mayday() {
  if (!state.where) return null;
  if (state.called) return html`<p role="status"><b>${say("mayday_called")}</b></p>`;
  return html`<${HoldButton} label=${say("mayday_hold")} name=${say("mayday_hold")} kind="mayday" onFire=${callMayday} />`;
}
