/** All missions: found, opened, taken to their next state, compared. */

import { ApiError, missionPath, request } from "../console/api.js";
import { age, missionClock } from "../console/format.js";
import { STATES, STEPS } from "../console/mission_state.js";
import { html, render } from "../console/vendor.js";
import { Comparison } from "./compare.js";
import { CreateForm } from "./create.js";

/** @import {MissionRow, Summary} from "./types.js" */

const AGAIN_MS = 5000;
const ROLES = ["viewer", "responder", "operator", "commander"];

export const state = {
  /** Null while nothing was heard. @type {MissionRow[] | null} */ missions: null,
  /** @type {{name: string, role: string, login: boolean} | null} */ me: null,
  /** @type {Set<string>} */ chosen: new Set(new URLSearchParams(location.search).get("compare")?.split(",").filter(Boolean)),
  /** What the comparison shows; null while it is closed. @type {Summary[] | null} */ compared: null,
  search: "",
  archived: false,
  trouble: "",
  /** Why the list is not what it is now. */ stale: "",
  busy: "",
};

const page = /** @type {HTMLElement} */ (document.getElementById("page"));

/** @param {string} text */
export function announce(text) {
  /** @type {HTMLElement} */ (document.getElementById("announcer")).textContent = text;
}

/** @param {string} role */
export const may = (role) => !state.me?.login || ROLES.indexOf(state.me.role) >= ROLES.indexOf(role);

/** Do something, say what went wrong, and show how things stand now. @param {string} what @param {() => Promise<void>} work */
export async function act(what, work) {
  Object.assign(state, { trouble: "", busy: what });
  show();
  try {
    await work();
    await load();
  } catch (error) {
    state.trouble = error instanceof Error ? error.message : String(error);
    announce(state.trouble);
  }
  state.busy = "";
  show();
}

async function load() {
  state.me ??= await request("GET", "/session");
  state.missions = (await request("GET", "/missions")).missions.reverse();
  state.stale = "";
}

/** Ask again and again; what was known stays on the page, and is said to be old. */
async function watch() {
  try {
    await load();
  } catch (error) {
    state.stale = error instanceof ApiError ? error.message : String(error);
  }
  show();
  setTimeout(watch, AGAIN_MS);
}

/** @param {MissionRow} mission @param {string} step @param {string} label */
const take = (mission, step, label) => act(`${mission.mission_id} ${step}`, async () => {
  await request("POST", `${missionPath(mission.mission_id)}/${step}`);
  announce(`${mission.name}: ${label}, done.`);
});

async function compare() {
  const ids = [...state.chosen];
  const address = new URL(location.href);
  address.searchParams.set("compare", ids.join(","));
  history.replaceState(null, "", address);
  await act("compare", async () => {
    state.compared = await Promise.all(ids.map((id) => request("GET", `${missionPath(id)}/summary`)));
  });
  document.getElementById("comparison")?.focus();
}

function closeComparison() {
  state.compared = null;
  history.replaceState(null, "", location.pathname);
  show();
}

/** @param {MissionRow} mission */
const isFound = (mission) => (state.archived || mission.state !== "archived")
  && `${mission.name} ${mission.mission_id} ${mission.state}`.toLowerCase().includes(state.search.trim().toLowerCase());

function List() {
  const missions = state.missions ?? [];
  const found = missions.filter(isFound);
  if (missions.length === 0) {
    return html`<p class="none"><b>No mission yet.</b> Make the first one below, or run <code>make run</code> for a demonstration
      with four robots.</p>`;
  }
  return html`<div class="row">
      <label class="grow">Search<input type="search" value=${state.search} placeholder="name, id or state"
        onInput=${(/** @type {any} */ event) => { state.search = event.currentTarget.value; show(); }}/></label>
      <label class="check"><input type="checkbox" checked=${state.archived} onChange=${() => {
        state.archived = !state.archived;
        show();
      }}/>Show archived</label>
      <button type="button" disabled=${state.chosen.size < 2 || state.busy !== ""} onClick=${compare}>${
        state.chosen.size < 2 ? "Compare: tick two or more" : `Compare ${state.chosen.size}`}</button></div>
    ${found.length === 0
      ? html`<p class="none">None of ${missions.length} missions fits${!state.archived && "; archived ones are not shown"}.</p>`
      : html`<div class="table" tabindex="0" role="region" aria-label="Missions"><table>
        <thead><tr><th><span class="unseen">Compare</span></th><th>Mission</th><th>State</th><th class="number">Robots</th>
          <th class="number">Explored</th><th class="number">Victims</th><th class="number">Tags</th><th>Ran for</th><th>Made</th>
          <th>Heard last</th><th><span class="unseen">What can be done</span></th></tr></thead>
        <tbody>${found.map((mission) => html`<${Row} key=${mission.mission_id} mission=${mission} />`)}</tbody></table></div>`}`;
}

/** @param {{mission: MissionRow}} props */
function Row({ mission }) {
  const now = Date.now() / 1000;
  const id = mission.mission_id;
  const [name, words] = STATES[mission.state];
  const isOver = ["closed", "archived"].includes(mission.state);
  return html`<tr class=${isOver ? "over" : ""} data-mission=${id}>
    <td><input type="checkbox" aria-label=${`Compare ${mission.name}`} checked=${state.chosen.has(id)} onChange=${() => {
      if (!state.chosen.delete(id)) state.chosen.add(id);
      show();
    }}/></td>
    <th scope="row"><a href=${`/console?mission=${encodeURIComponent(id)}`}>${mission.name}</a></th>
    <td><span class=${`mission-state mission-${mission.state}`} title=${words}>${name}</span></td>
    <td class="number">${mission.robots}</td><td class="number">${Math.round(mission.explored_m2)} m²</td>
    <td class="number">${mission.victims}</td><td class="number">${mission.tags}</td>
    <td>${missionClock(mission.duration_s)}</td><td>${age(Math.max(0, now - mission.created_unix_s))}</td>
    <td>${age(mission.heard_unix_s === null ? null : Math.max(0, now - mission.heard_unix_s))}</td>
    <td>${STEPS[mission.state].filter(([, , role]) => may(role)).map(([step, label]) => html`<button type="button" key=${step}
      aria-label=${`${label}: ${mission.name}`} disabled=${state.busy !== ""} onClick=${() => take(mission, step, label)}>${
        state.busy === `${id} ${step}` ? "Working…" : label}</button>`)}</td></tr>`;
}

export function show() {
  page.setAttribute("aria-busy", String(state.missions === null && !state.stale));
  if (state.missions === null) {
    render(state.stale
      ? html`<section><h2>The missions cannot be shown</h2><p role="alert">${state.stale} Trying again every five seconds.</p></section>`
      : html`<p>Loading the missions.</p>`, page);
    return;
  }
  render(html`
    ${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}
    ${state.compared && html`<${Comparison} summaries=${state.compared} onClose=${closeComparison} />`}
    <section aria-label="All missions"><h2>All missions</h2>
      ${state.stale && html`<p class="stale" role="status">${state.stale} What you see is the last that was known.</p>`}
      <${List} /></section>
    ${may("operator") ? html`<${CreateForm} missions=${state.missions} />`
      : html`<p class="about">A new mission is made by an operator or a commander; you are logged in as ${state.me?.role}.</p>`}`, page);
}

page.textContent = "";
show();
watch().then(() => {
  if (state.chosen.size > 1) compare();
});
