/** The way there: one arrow, one number, the next tag. */

import { html } from "../console/vendor.js";
import { lead } from "./lead.js";
import { state } from "./state.js";
import { say } from "./texts.js";

/** @typedef {import("./texts.js").Key} Key */

/** @param {number} far_m */
export const far = (far_m) => say("metres", { n: Math.max(1, Math.round(far_m)) });

/** @param {{route: import("./state.js").Route, to: string}} props */
export function Guide({ route, to }) {
  const step = route.legs[0] ?? route.last;
  const [kind, name] = to.split(":");
  const goal = say(/** @type {Key} */ (`goal_${kind}`), { name });
  if (!step) return html`<section class="go"><p class="next">${say("there", { goal })}</p>
    <button type="button" onClick=${() => lead(null)}>${say("done")}</button></section>`;
  const turn = step.bearing_deg - (state.heading ?? 0);
  const here = far(step.distance_m);
  return html`<section class="go" aria-label=${say("way_to", { goal })}>
    <p class="soft">${say("to_goal", { goal, far: far(route.distance_m) })}</p>
    <svg viewBox="0 0 100 100" role="img" aria-label=${say("arrow", { degrees: Math.round(step.bearing_deg) })}>
      <g transform=${`rotate(${turn} 50 50)`}><path d="M50 6 86 80 50 64 14 80Z" fill="var(--accent)" /></g></svg>
    <p class="number">${step.uncertain ? say("about", { far: here }) : here}</p>
    <p class="next">${step.to_tag ? say("to_tag", { tag: step.to_tag }) : say(/** @type {Key} */ (`to_the_${kind}`))}</p>
    <p class="text">${step.text}</p>
    ${state.heading === null && html`<p class="soft">${say("north_up")}</p>`}
    ${step.to_tag && html`<a class="soft" href=${`/t/${encodeURIComponent(step.to_tag)}`}>${say("i_am_at", { tag: step.to_tag })}</a>`}
    <button type="button" onClick=${() => lead(null)}>${say("stop_leading")}</button></section>`;
}
