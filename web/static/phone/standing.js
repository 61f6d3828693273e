/** How things stand with this phone: how old its data are, whether the server is in reach, what waits to be sent. */

import { html } from "../console/vendor.js";
import { HandOver, Offered } from "./handover_view.js";
import { forget, isFull, sendNow, waiting } from "./outbox.js";
import { pockets } from "./pockets.js";
import { now_s, reach } from "./reach.js";
import { textOf, timeOf } from "./report_words.js";
import { changed, state } from "./state.js";
import { say } from "./texts.js";

/** @import {Report} from "./outbox.js" */

/** How long ago, in words. @param {number} seconds */
export function ago(seconds) {
  if (seconds < -60) return say("age_unknown");
  if (seconds < 90) return say("age_seconds", { n: Math.max(0, Math.round(seconds)) });
  if (seconds < 5400) return say("age_minutes", { n: Math.round(seconds / 60) });
  return seconds < 172_800 ? say("age_hours", { n: Math.round(seconds / 3600) }) : say("age_days", { n: Math.round(seconds / 86_400) });
}

let isOpen = false;
let isHandingOver = false;

export function Standing() {
  const { as_of_s } = state;
  const reports = waiting().filter(({ kind }) => kind !== "at");
  const refused = reports.filter((report) => report.refused).length;
  return html`<${Offered} />${as_of_s !== null && html`<p class="age">${say("data_of", { time: timeOf(as_of_s), age: ago(now_s() - as_of_s) })}</p>`}
    ${reach.inReach === false && html`<p class="warned">${say("no_signal")}</p>`}
    ${reach.isLoggedOut && html`<p class="warned">${say("logged_out", { n: reports.length, count: reports.length })}
      <a class="button" href=${`/login?next=${encodeURIComponent(location.pathname + location.search)}`}>${say("log_in")}</a></p>`}
    ${Math.abs(reach.offset_s ?? 0) > 120 && html`<p class="warned">${say("clock_wrong")}</p>`}
    ${isFull() && html`<p class="trouble" role="alert">${say("storage_full")}</p>`}
    ${pockets.isFull && !isFull() && html`<p class="warned">${say("storage_full_mission")}</p>`}
    ${refused > 0 && html`<p class="trouble" role="alert">${say("some_refused", { n: refused })}</p>`}
    ${reports.length > 0 && html`<button type="button" aria-expanded=${isOpen} onClick=${() => { isOpen = !isOpen; isHandingOver = false; changed(); }}>
      ${say("reports_wait", { n: reports.length })}</button>`}
    ${isOpen && reports.length > 0 && (isHandingOver ? html`<${HandOver} />`
      : html`<ul>${reports.map(Waiting)}</ul><button type="button" onClick=${() => { isHandingOver = true; changed(); }}>
        ${say("handover")}</button>`)}`;
}

/** @param {Report} report */
function Waiting(report) {
  return html`<li key=${report.id} class="waiting"><p>${textOf(report)}</p>
    ${report.refused && html`<p class="trouble">${report.refused}</p>
      <div class="row"><button type="button" onClick=${() => sendNow(true)}>${say("try_again")}</button>
      <button type="button" onClick=${async () => { await forget(report.id); changed(report.kind === "mayday" ? { called: null } : {}); }}>${say("throw_away")}</button></div>`}</li>`;
}
