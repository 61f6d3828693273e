/** The responder's phone at a tag: where am I, who is near, the way there tag by tag, and leaving word; with or without signal. */

import { html, render } from "../console/vendor.js";
import { Alarm, lookForOrders, Mayday } from "./alarm.js";
import { countSteps, placeNow } from "./between.js";
import { askForSensors, needsAsking, watchCompass } from "./compass.js";
import { Doubt, Entry } from "./entry.js";
import { Guide } from "./guide.js";
import { MemoryView } from "./memory_view.js";
import { openOutbox } from "./outbox.js";
import { Nodes } from "./listen.js";
import { PlanView } from "./plan.js";
import { openPockets } from "./pockets.js";
import { askWho, onReach } from "./reach.js";
import { Word } from "./report.js";
import { keepHere } from "./shell.js";
import { Standing } from "./standing.js";
import { changed, onChange, state } from "./state.js";
import { language, LANGUAGES, say, speak } from "./texts.js";
import { answer, keepFresh, lead, target, touch } from "./touch.js";
import { metres } from "./words.js";

/** @typedef {import("./texts.js").Key} Key */

const AGES_MS = 10_000;

function Page() {
  const { where } = state;
  const trouble = html`${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}<${Doubt} />`;
  if (!where) return html`<h1>${say("which_tag")}</h1>${trouble}${state.said && html`<p role="status">${state.said}</p>`}<${Entry} /><${Nodes} />${state.fix && html`<${PlanView} />`}<${Languages} />`;
  const goal = target();
  return html`<h1>${say("tag", { tag: where.tag_id })}</h1>
    ${trouble}
    ${state.said && html`<p role="status">${state.said}</p>`}
    ${goal && state.route && html`<${Guide} route=${state.route} to=${goal.to} />`}
    <p class="where">${where.text}${where.sd_m > 1 ? ` ${say("place_unsure", { far: metres(where.sd_m) })}` : ""}</p>
    ${where.notice && html`<p class="trouble">${where.notice}</p>`}
    ${where.victims.length > 0 && html`<h2>${say("lead_me_to")}</h2><ul>${where.victims.map(NearVictim)}</ul>`}
    ${state.pocket && html`<${Between} /><${Nodes} /><${PlanView} />`}
    <${MemoryView} />
    <${Word} />
    <h2>${say("at_another_tag")}</h2><${Entry} />
    <p class="soft">${where.mission_name}</p><${Languages} />`;
}

/** How far the phone has come from the tag by its own steps. */
function Between() {
  const place = placeNow();
  if (place) return html`<p>${say("steps", { n: place.steps, tag: state.tagId, far: metres(2 * place.sd_m) })}</p>`;
  return needsAsking() && state.heading === null
    && html`<button type="button" onClick=${askForSensors}>${say("use_compass")}</button>`;
}

/** Speaking another language. */
function Languages() {
  const others = Object.entries(LANGUAGES).filter(([name]) => name !== language());
  return html`${others.map(([name, { name: own }]) => html`<button key=${name} type="button" lang=${name}
    onClick=${() => { speak(name); answer(); changed(); }}>${own}</button>`)}`;
}

/** @param {import("./types.js").NearVictim} victim */
function NearVictim({ victim_id, status, reachable, distance_m }) {
  return html`<li key=${victim_id}><button type="button" disabled=${!reachable} onClick=${() => lead(`victim:${victim_id}`)}>
    <span>${say("victim", { victim: victim_id })}<span class="soft"> ${say(reachable ? /** @type {Key} */ (`status_${status}`) : "no_way_known")}</span></span>
    <span class="far">${metres(distance_m)}</span></button></li>`;
}

const [alarm, standing, page, foot] = ["alarm", "standing", "page", "foot"].map((id) => /** @type {HTMLElement} */ (document.getElementById(id)));

function draw() {
  document.title = `${state.tagId ? say("tag", { tag: state.tagId }) : say("which_tag")} · Waymark`;
  render(html`<${Alarm} />`, alarm);
  render(html`<${Standing} />`, standing);
  render(html`<${Page} />`, page);
  render(html`<${Mayday} />`, foot);
}

/** The tag and mission that an address of this page names. */
function here(address = new URL(location.href)) {
  const [, first, tag] = address.pathname.split("/");
  return /** @type {const} */ ([first === "t" ? decodeURIComponent(tag ?? "") : "", address.searchParams.get("mission")]);
}

addEventListener("popstate", () => touch(...here(), true));

document.documentElement.lang = language();
page.textContent = "";
onChange(draw);
onReach(changed);
watchCompass(changed);
countSteps(changed);
await openPockets();
const [tagId, mission] = here();
if (tagId) touch(tagId, mission, true);
else answer();
changed();
askWho();
openOutbox();
keepFresh();
lookForOrders();
setInterval(changed, AGES_MS); // ages go on
keepHere();
// an installed page that is open takes the tag that was touched, without loading anything
/** @type {any} */ (globalThis).launchQueue?.setConsumer((/** @type {{targetURL?: string}} */ { targetURL }) => {
  if (targetURL && targetURL !== location.href) touch(...here(new URL(targetURL)));
});
