/** A victim as it is marked with paint beside it: INSARAG (editions of 2020 and 2027 agree here) and FEMA. */

import { html } from "./vendor.js";

/** @import {Victim} from "./types.js" */

const PAINT = "var(--marking)";

/** What stands there now, in words. @param {Victim} victim */
export function markingWords({ live, dead, status }) {
  if (live === null && dead === null) return status === "extricated" ? "V, nobody left" : "V: a potential victim";
  const left = [live ? `${live} live` : "", dead ? `${dead} dead` : ""].filter(Boolean);
  return left.length ? `V, ${left.join(" and ")} still there` : "V, nobody left";
}

/** @param {{victim: Victim}} props */
export function Markings({ victim }) {
  return html`<div class="markings">
    <figure><${Insarag} victim=${victim} /><figcaption>INSARAG 2020, 2027</figcaption></figure>
    <figure><${Fema} victim=${victim} /><figcaption>FEMA</figcaption></figure>
    <p>${markingWords(victim)}</p></div>`;
}

/** A V with L-n and D-n below; what was there and is no more is crossed out. @param {{victim: Victim}} props */
function Insarag({ victim }) {
  const lines = [["L", victim.live], ["D", victim.dead]].filter(([, count]) => count !== null);
  return html`<svg viewBox="0 0 100 100" role="img" aria-label=${`INSARAG marking: ${markingWords(victim)}`}>
    <path d="M26 8 50 60 74 8" fill="none" style=${{ stroke: PAINT }} stroke-width="9" stroke-linecap="square" />
    ${lines.map(([letter, count], k) => html`<g>
      <text x="50" y=${78 + 20 * k - (lines.length - 1) * 2} text-anchor="middle" font-size="19" font-weight="700"
        style=${{ fill: PAINT }}>${letter}-${count}</text>
      ${count === 0 && html`<path d=${`M30 ${72 + 20 * k}H70`} style=${{ stroke: PAINT }} stroke-width="4" />`}</g>`)}
  </svg>`;
}

/** A V; a circle when somebody lives, a bar when only dead are there, an X when all were removed. @param {{victim: Victim}} props */
function Fema({ victim }) {
  const { live, dead, status } = victim;
  const isRemoved = status === "extricated" || (live === 0 && (dead ?? 0) === 0);
  return html`<svg viewBox="0 0 100 100" role="img" aria-label=${`FEMA marking: ${markingWords(victim)}`}>
    <path d="M28 22 50 74 72 22" fill="none" style=${{ stroke: PAINT }} stroke-width="9" stroke-linecap="square" />
    ${(live ?? 0) > 0 && html`<circle cx="50" cy="46" r="42" fill="none" style=${{ stroke: PAINT }} stroke-width="6" />`}
    ${!live && (dead ?? 0) > 0 && html`<path d="M14 46H86" style=${{ stroke: PAINT }} stroke-width="7" />`}
    ${isRemoved && html`<path d="M16 12 84 84M84 12 16 84" style=${{ stroke: PAINT }} stroke-width="6" />`}
  </svg>`;
}
