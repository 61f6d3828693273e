/** What was found and what happened: the victims and the feed of events. */

import { missionPath, request } from "./api.js";
import { fixed, percent, timeOfDay } from "./format.js";
import { html } from "./vendor.js";
import { statusOf, VICTIM_STATUSES } from "./victim_status.js";

/** @import {MissionEvent, Victim} from "./types.js" */
/** @import {Store} from "./store.js" */

/** Victims that still need somebody first, then by confidence. */
const URGENCY = ["suspected", "confirmed", "reached", "extricated", "dismissed"];

/** @param {{store: Store, onSelect: (id: string) => void}} props */
export function VictimList({ store, onSelect }) {
  const victims = [...store.victims.values()].sort((a, b) =>
    URGENCY.indexOf(a.status) - URGENCY.indexOf(b.status) || b.confidence - a.confidence);
  return html`
    <h2 class="panel-title">Victims <span class="count">${victims.length || ""}</span></h2>
    ${victims.length === 0 && html`<p class="hint">No victim has been seen yet.</p>`}
    <ul class="cards">
      ${victims.map((victim) => html`<${VictimCard} key=${victim.victim_id} victim=${victim} store=${store}
        onSelect=${onSelect} />`)}
    </ul>`;
}

/** @param {{victim: Victim, store: Store, onSelect: (id: string) => void}} props */
function VictimCard({ victim, store, onSelect }) {
  const id = victim.victim_id;
  const isSelected = store.selected?.kind === "victim" && store.selected.id === id;
  const status = statusOf(victim.status);
  const seen = `Seen ${victim.sightings === 1 ? "once" : `${victim.sightings} times`}`
    + (victim.robots?.length ? ` by ${victim.robots.join(", ")}` : "");
  return html`
    <li class=${`card victim-card ${isSelected ? "selected" : ""}`} data-victim=${id} data-status=${victim.status}>
      <button class="card-body" type="button" aria-pressed=${isSelected} onClick=${() => onSelect(id)}
              title=${`Show victim ${id} in the middle of the plan`}>
        <span class="card-head">
          <span class="victim-glyph" aria-hidden="true">${status.glyph}</span>
          <span class="card-name">${id}</span>
          <span class="confidence"><b>${percent(victim.confidence)}</b> sure</span>
        </span>
        <span class="reason">${seen}, at ${fixed(victim.x_m, 1)}\u00a0/\u00a0${fixed(victim.y_m, 1)}\u00a0m.</span>
        ${victim.note && html`<span class="reason">${victim.note}</span>`}
      </button>
      <label class="card-foot">
        <span>Status</span>
        <select value=${victim.status} onChange=${(/** @type {Event} */ event) => setStatus(store, victim, event)}>
          ${Object.entries(VICTIM_STATUSES).map(([value, { label }]) =>
            html`<option value=${value} selected=${value === victim.status}>${label}</option>`)}
        </select>
      </label>
    </li>`;
}

/**
 * @param {Store} store
 * @param {Victim} victim
 * @param {Event} event
 */
async function setStatus(store, victim, event) {
  const select = /** @type {HTMLSelectElement} */ (event.currentTarget);
  const path = `${missionPath(store.missionId ?? "")}/victims/${encodeURIComponent(victim.victim_id)}`;
  select.disabled = true;
  try {
    await request("PATCH", path, { status: select.value });
  } catch (error) {
    store.notify(`The status of victim ${victim.victim_id} was not changed. ${/** @type {Error} */ (error).message}`);
    select.value = store.victims.get(victim.victim_id)?.status ?? victim.status;
  } finally {
    select.disabled = false;
    store.changed();
  }
}

/** @param {{store: Store, onSelect: (id: string) => void}} props */
export function EventFeed({ store, onSelect }) {
  const events = [...store.events.values()].sort((a, b) => Number(b.event_id) - Number(a.event_id));
  return html`
    <h2 class="panel-title">Events</h2>
    ${events.length === 0 && html`<p class="hint">Nothing has happened yet.</p>`}
    <ol class="events" tabindex="0" aria-label="Latest events, newest first">
      ${events.map((event) => html`<${EventLine} key=${event.event_id} event=${event} store=${store}
        onSelect=${onSelect} />`)}
    </ol>`;
}

/** @param {{event: MissionEvent, store: Store, onSelect: (id: string) => void}} props */
function EventLine({ event, store, onSelect }) {
  const robotId = event.robot_id && store.robots.has(event.robot_id) ? event.robot_id : null;
  const text = html`<time datetime=${new Date(event.unix_s * 1000).toISOString()}>${timeOfDay(event.unix_s)}</time>
    <span class="event-text">${event.severity !== "info" && html`<b>${
      event.severity === "alarm" ? "Alarm" : "Warning"}: </b>`}${event.text}</span>`;
  return html`<li class=${`event event-${event.severity}`}>
    ${robotId
      ? html`<button type="button" onClick=${() => onSelect(robotId)} title=${`Show ${robotId}`}>${text}</button>`
      : html`<div>${text}</div>`}
  </li>`;
}
