/** The inbox of victims: who waits to be looked at, the surest first; one of them is open at a time. */

import { fixed, percent } from "./format.js";
import { html } from "./vendor.js";
import { VictimCase } from "./victim_case.js";
import { say, standing } from "./victim_list.js";
import { statusOf, VICTIM_STATUSES } from "./victim_status.js";

/** @import {Victim} from "./types.js" */
/** @import {Store} from "./store.js" */

/** Keys that judge the selected victim, beside J and K for the next and the one before. @type {Record<string, string>} */
const KEYS = { c: "confirmed", r: "reached", e: "extricated", x: "dismissed" };

/**
 * J and K go through the inbox, C, R, E and X judge the one that is open.
 * @param {Store} store
 * @param {string} key
 * @param {(id: string) => void} onSelect
 */
export function inboxKey(store, key, onSelect) {
  const victims = standing(store);
  const at = victims.findIndex(({ victim_id }) => store.selected?.kind === "victim" && store.selected.id === victim_id);
  const victim = victims[at];
  if (key === "j" || key === "k") {
    const next = victims[at < 0 ? 0 : (at + (key === "j" ? 1 : victims.length - 1)) % victims.length];
    if (next) onSelect(next.victim_id);
  } else if (victim && Object.hasOwn(KEYS, key)) say(store, victim, { status: KEYS[key] });
}

/** @param {{store: Store, onSelect: (id: string) => void}} props */
export function VictimInbox({ store, onSelect }) {
  const victims = standing(store);
  const unseen = victims.filter(({ by }) => by === "").length;
  return html`
    <h2 class="panel-title">Victims <span class="count">${victims.length || ""}</span>
      ${unseen > 0 && html`<span class="badge new">${unseen} new</span>`}
      ${victims.length > 0 && html`<span class="keys" title="J and K: next and the one before; C confirm, R reached, E extricated, X dismiss">
        <kbd>J</kbd> <kbd>K</kbd> <kbd>C</kbd> <kbd>X</kbd></span>`}</h2>
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
    <li class=${`card victim-card ${isSelected ? "selected" : ""} ${victim.by === "" ? "unseen-victim" : ""}`}
        data-victim=${id} data-status=${victim.status}>
      <button class="card-body" type="button" aria-pressed=${isSelected} onClick=${() => onSelect(id)}
              title=${`Show victim ${id} in the middle of the plan`}>
        <span class="card-head">
          <span class="victim-glyph" aria-hidden="true">${status.glyph}</span>
          <span class="card-name">${id}</span>
          ${victim.triage !== "unknown" && html`<span class=${`triage triage-${victim.triage}`}>${victim.triage}</span>`}
          <span class="confidence"><b>${percent(victim.confidence)}</b> sure</span>
        </span>
        <span class="reason">${seen}, at ${fixed(victim.x_m, 1)}\u00a0/\u00a0${fixed(victim.y_m, 1)}\u00a0m${
          victim.team && `; ${victim.team} is on it`}.</span>
        ${victim.note && html`<span class="reason">${victim.note}</span>`}
      </button>
      <label class="card-foot">
        <span>Status</span>
        <select value=${victim.status} disabled=${store.isOver} onChange=${(/** @type {any} */ event) => say(store, victim, { status: event.currentTarget.value })}>
          ${Object.entries(VICTIM_STATUSES).map(([value, { label }]) =>
            html`<option value=${value} selected=${value === victim.status}>${label}</option>`)}
        </select>
      </label>
      ${isSelected && html`<${VictimCase} victim=${victim} store=${store} />`}
    </li>`;
}
