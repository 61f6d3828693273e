/** How the mission stands, what that means, and taking it to its next state. */

import { missionPath, request } from "./api.js";
import { BaseMapLines } from "./base_map.js";
import { missionClock, timeOfDay } from "./format.js";
import { openGeoreference } from "./georeference.js";
import { html } from "./vendor.js";

/** @import {Mission} from "./types.js" */
/** @import {Store} from "./store.js" */

/** State -> its name, and what it means. @type {Record<string, [string, string]>} */
export const STATES = {
  draft: ["Draft", "Robots may join. What they observe is refused until somebody starts the mission."],
  running: ["Running", "Robots explore, and everything is logged."],
  paused: ["Paused", "All robots stand still. What they observe is logged on."],
  closed: ["Closed", "The mission is over. It can be read, and nothing in it changes any more."],
  archived: ["Archived", "The mission is over and out of sight. It can still be read."],
};

/** State -> what can be done: its step, its name, and who may. @type {Record<string, [string, string, string][]>} */
export const STEPS = {
  draft: [["start", "Start the mission", "operator"]],
  running: [["pause", "Pause the mission", "operator"], ["close", "Close the mission", "commander"]],
  paused: [["start", "Start again", "operator"], ["close", "Close the mission", "commander"]],
  closed: [["reopen", "Reopen, paused", "commander"], ["archive", "Archive", "commander"]],
  archived: [["reopen", "Reopen, paused", "commander"]],
};

/** Seconds that a mission has been running in all. @param {Mission} mission @param {number} now_unix_s */
export const duration_s = (mission, now_unix_s) =>
  (mission.ran_s ?? 0) + (mission.state === "running" ? Math.max(0, now_unix_s - (mission.state_unix_s ?? now_unix_s)) : 0);

/** @param {Store} store @param {string} step */
async function take(store, step) {
  try {
    await request("POST", `${missionPath(store.missionId ?? "")}/${step}`);
    store.withdraw("The mission stays");
  } catch (error) {
    store.notify(`The mission stays as it is. ${/** @type {Error} */ (error).message}`);
  }
}

/** In the bar: the state, and behind it what can be done. @param {{store: Store}} props */
export function MissionMenu({ store }) {
  const { mission } = store;
  if (!mission) return html`<a class="all-missions" href="/missions">All missions</a>`;
  const [name, words] = STATES[mission.state] ?? [mission.state, ""];
  return html`<details class="pop mission-menu">
    <summary class=${`mission-state mission-${mission.state}`} aria-label=${`The mission is ${name.toLowerCase()}; what can be done`}>${name}</summary>
    <div class="pop-card">
      <p>${words}</p>
      <p class="hint-line">Running for ${missionClock(duration_s(mission, store.serverNow()))} in all${
        mission.state_by && `; ${name.toLowerCase()} since ${timeOfDay(mission.state_unix_s ?? 0)} by ${mission.state_by}`}.</p>
      ${(STEPS[mission.state] ?? []).map(([step, label, role]) => html`<button type="button" key=${step}
        disabled=${!store.may(role)} title=${store.may(role) ? "" : `For the role ${role}`}
        onClick=${() => take(store, step)}>${label}</button>`)}
      ${!store.isOver && store.may("operator") && html`<button type="button" onClick=${(/** @type {any} */ event) => {
        event.currentTarget.closest("details").open = false;
        openGeoreference(store);
      }}>Place on the Earth…</button><${BaseMapLines} store=${store} />`}
      <a href=${`/api/v1${missionPath(mission.mission_id)}/report.html`} target="_blank" rel="noopener">Report to hand over</a>
      <a href="/missions">All missions</a>
    </div></details>`;
}

/** A strip while the mission does not run. @param {{store: Store}} props */
export function MissionBanner({ store }) {
  const { mission } = store;
  if (!mission || mission.state === "running") return null;
  const [name, words] = STATES[mission.state] ?? [mission.state, ""];
  const start = (STEPS[mission.state] ?? []).find(([step]) => step === "start");
  return html`<div class="mission-banner" role="status"><span><b>${name}.</b> ${words}</span>
    ${start && store.may(start[2]) && html`<button type="button" onClick=${() => take(store, "start")}>${start[1]}</button>`}</div>`;
}
