/** What happened: the feed of events. */

import { timeOfDay } from "./format.js";
import { html } from "./vendor.js";

/** @import {MissionEvent} from "./types.js" */
/** @import {Store} from "./store.js" */

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
