/** The responder's phone at a tag: where am I, who is near, the way there tag by tag. What else the page has comes once the answer stands. */

import { html, render } from "../console/vendor.js";
import { here } from "./address.js";
import { Guide } from "./guide.js";
import { language } from "./language.js";
import { loaded } from "./loaded.js";
import { painted } from "./painted.js";
import { whereText } from "./past.js";
import { opened } from "./pockets.js";
import { changed, onChange, state } from "./state.js";
import { say } from "./texts.js";
import { told } from "./told.js";
import { answer, lead, target, touch } from "./touch.js";
import { wordsOf } from "./where.js";
import { metres, rounded } from "./words.js";

/** @typedef {import("./texts.js").Key} Key */

/** @type {typeof import("./rest.js") | null} */
let rest = null;

function Page() {
  const { where } = state;
  const trouble = html`${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}${rest && html`<${rest.Doubt} />`}
    ${state.odd && html`<p class="trouble" role="alert">${say("too_far", { ...state.odd, far: metres(state.odd.far_m), after: rounded(state.odd.after_s) })}</p>`}
    ${where && state.elsewhere && html`<p class="trouble" role="alert">${say("tag_elsewhere", { mission: where.mission_name, own: state.elsewhere })}</p>`}
    ${state.said && html`<p role="status">${state.said}</p>`}`;
  if (!where) return html`<h1>${say("which_tag")}</h1>${trouble}${rest && html`<${rest.WhichTag} />`}`;
  const goal = target();
  const { title, text, warning } = wordsOf({ ...where, text: whereText(where) });
  return html`<h1>${title}</h1>
    ${trouble}
    ${goal && state.route && html`<${Guide} route=${state.route} to=${goal.to} />`}
    <p class="where">${text}</p>
    ${warning && html`<p class="trouble">${warning}</p>`}
    ${where.victims.length > 0 && html`<h2>${say("lead_me_to")}</h2><ul>${where.victims.map(NearVictim)}</ul>`}
    ${rest && html`<${rest.AtTag} mission=${where.mission_name} />`}`;
}

/** @param {import("./types.js").NearVictim} victim */
function NearVictim({ victim_id, status, reachable, distance_m }) {
  return html`<li key=${victim_id}><button type="button" disabled=${!reachable} onClick=${() => lead(`victim:${victim_id}`)}>
    <span>${say("victim", { victim: victim_id })}<span class="soft"> ${say(reachable ? /** @type {Key} */ (`status_${status}`) : "no_way_known")}</span></span>
    <span class="far">${metres(distance_m)}</span></button></li>`;
}

/** @param {string} id */
const place = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

function draw() {
  document.title = `${state.tagId ? say("tag", { tag: state.tagId }) : say("which_tag")} · Waymark`;
  render(html`<${Page} />`, place("page"));
  if (!rest) return;
  render(html`<${rest.Alarm} />`, place("alarm"));
  render(html`<${rest.Standing} />`, place("standing"));
  render(html`<${rest.Mayday} />`, place("foot"));
}

/** When a touch has opened this page, by the phone's clock; null where it was loaded again or gone back to. */
function openedByTag() {
  const [how] = /** @type {PerformanceNavigationTiming[]} */ (performance.getEntriesByType("navigation"));
  // timeOrigin itself is of a clock that stands still while the phone sleeps
  return how?.type === "navigate" ? (Date.now() - performance.now()) / 1000 : null;
}

/** What is there already says the same: it is taken over as it stands. */
export async function begin() {
  document.documentElement.lang = language();
  await opened;
  onChange(draw);
  const [tagId, mission] = here();
  if (!tagId) answer();
  touch(tagId, mission, true, told, openedByTag());
  addEventListener("popstate", () => touch(...here(), true));
  await painted();
  const trouble = say("half_loaded");
  rest = await loaded(() => import("./rest.js"), () => changed({ trouble }));
  if (state.trouble === trouble) state.trouble = "";
  rest.start();
  // an installed page that is open takes the tag that was touched, without loading anything
  /** @type {any} */ (globalThis).launchQueue?.setConsumer((/** @type {{targetURL?: string}} */ { targetURL }) => {
    if (targetURL && targetURL !== location.href) touch(...here(new URL(targetURL)), false, null, Date.now() / 1000);
  });
}
