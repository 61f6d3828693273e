/** Alerts, and the card of the selected tag with what it measures. */

import { age, fixed, timeOfDay } from "./format.js";
import { acknowledge, alarming, ALERT_KINDS, alertsOf, endMayday, isOpen, readings, subjectOf } from "./node_sensors.js";
import { Photos } from "./photos.js";
import { TagMemory } from "./tag_memory.js";
import { html } from "./vendor.js";

/** @import {Alert} from "./types.js" */
/** @import {Store} from "./store.js" */
/** @typedef {{kind: "robot" | "victim" | "tag", id: string}} Subject */

/** Nothing at all while there is none. @param {{store: Store, onSelect: (subject: Subject) => void}} props */
export function AlertList({ store, onSelect }) {
  const alerts = alertsOf(store);
  if (!alerts.length) return null;
  const open = alerts.filter(isOpen);
  return html`
    <h2 class="panel-title">Alerts <span class="count">${open.length || ""}</span>
      ${open.length > 1 && html`<button type="button" class="all" onClick=${(/** @type {Event} */ event) =>
        acknowledge(store, open, event)}>Acknowledge all</button>`}</h2>
    <ul class="cards">
      ${alerts.map((alert) => html`<${AlertCard} key=${alert.alert_id} alert=${alert} store=${store}
        onSelect=${onSelect} />`)}
    </ul>`;
}

/** @param {{alert: Alert, store: Store, onSelect: (subject: Subject) => void}} props */
function AlertCard({ alert, store, onSelect }) {
  const kind = ALERT_KINDS[alert.kind];
  const subject = subjectOf(alert);
  const isSelected = subject !== null && store.selected?.kind === subject.kind && store.selected.id === subject.id;
  return html`
    <li class=${`card alert-card alert-${alert.severity} ${isOpen(alert) ? "" : "noted"} ${
      isSelected ? "selected" : ""}`} data-alert=${alert.alert_id}>
      <button class="card-body" type="button" disabled=${subject === null}
              onClick=${() => subject && onSelect(subject)} title=${subject ? `Show ${subject.id} on the plan` : ""}>
        <span class="card-head">
          <span class="alert-glyph" aria-hidden="true">${kind?.glyph}</span>
          <span class="card-name">${subject?.id ?? kind?.label}</span>
          <span class="alert-kind" title=${kind?.label}>${alarming(alert, store.nodes.get(alert.tag_id ?? ""))}</span>
        </span>
        <span class="reason">${alert.text}</span>
        <span class="reason">Since ${timeOfDay(alert.raised_unix_s)}${
          alert.over_unix_s != null && `, over since ${timeOfDay(alert.over_unix_s)}`}.</span>
      </button>
      <${Acknowledgement} alert=${alert} store=${store} />
    </li>`;
}

/** @param {{alert: Alert, store: Store}} props */
function Acknowledgement({ alert, store }) {
  if (!isOpen(alert)) return html`<p class="card-foot">Noted by ${alert.acknowledged_by}
    ${alert.kind === "mayday" && alert.over_unix_s == null && html`<button type="button"
      onClick=${() => endMayday(store, alert)}>It is over</button>`}</p>`;
  return html`<div class="card-foot"><span>New</span>
    <button type="button" onClick=${(/** @type {Event} */ event) => acknowledge(store, [alert], event)}
            aria-label=${`Acknowledge: ${alert.text}`}>Acknowledge</button></div>`;
}

/** Over the plan: what is known of the selected tag. @param {{store: Store}} props */
export function TagCard({ store }) {
  if (store.selected?.kind !== "tag") return null;
  const id = store.selected.id;
  const tag = store.shown.tags.get(id);
  const node = store.nodes.get(id);
  if (!tag && !node) return null;
  return html`
    <section class="tag-card" aria-label=${`Tag ${id}`} data-tag=${id}>
      <header><h3>${id}</h3>
        <button type="button" aria-label=${`Close the card of tag ${id}`} onClick=${() => store.select(null)}>×</button>
      </header>
      ${tag
        ? html`<p>At ${fixed(tag.x_m, 1)}\u00a0/\u00a0${fixed(tag.y_m, 1)}\u00a0m, read ${
          tag.sightings === 1 ? "once" : `${tag.sightings} times`} by ${tag.robots.join(", ")}.</p>`
        : html`<p>Heard by radio; where it is, is not known yet.</p>`}
      ${tag?.notice && html`<p class="warn">${tag.notice}</p>`}
      <${Photos} store=${store} of=${{ tag_id: id }} />
      ${tag && html`<${TagMemory} key=${id} store=${store} tagId=${id} />`}
      ${node && html`
        <dl class="readings">${readings(node).map(([label, value]) =>
          html`<div><dt>${label}</dt><dd>${value}</dd></div>`)}</dl>
        <p class="hint-line">Heard by ${node.robot_id} ${age(Math.max(0, store.moment() - node.heard_unix_s))}.</p>`}
      ${alertsOf(store, id).map((alert) => html`
        <div class=${`tag-alert alert-${alert.severity}`} key=${alert.alert_id}><b>${alert.text}</b>
          <${Acknowledgement} alert=${alert} store=${store} /></div>`)}
    </section>`;
}
