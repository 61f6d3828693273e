/** The rest of the phone's page, loaded once the answer stands: plan, memory, leaving word, other tags, orders, and what keeps it fresh. */

import { html } from "../console/vendor.js";
import { Alarm, listenForOrders, Mayday } from "./alarm.js";
import { countSteps, placeNow } from "./between.js";
import { askForSensors, needsAsking, watchCompass } from "./compass.js";
import { Doubt, Entry } from "./entry.js";
import { put } from "./kept.js";
import { language, speak, SPOKEN } from "./language.js";
import { Nodes } from "./listen.js";
import { MemoryView } from "./memory_view.js";
import { openOutbox } from "./outbox.js";
import { PlanView } from "./plan.js";
import { askWho, onReach } from "./reach.js";
import { Word } from "./report.js";
import { keepHere, WithoutHttps } from "./shell.js";
import { Standing } from "./standing.js";
import { changed, onChange, state } from "./state.js";
import { LANGUAGES, say } from "./texts.js";
import { answer, keepFresh, target } from "./touch.js";
import { stayAwake } from "./wake.js";
import { WayOut } from "./way_out.js";
import { metres } from "./words.js";

export { Alarm, Doubt, Mayday, Standing };

const AGES_MS = 10_000;

/** Where no tag was read. */
export function WhichTag() {
  return html`<${Entry} /><${Nodes} />${state.fix && html`<${PlanView} />`}<p class="soft">${say("evacuate_how")}</p>
    <${WithoutHttps} /><${Languages} />`;
}

/** Below the answer. @param {{mission: string}} props its name */
export function AtTag({ mission }) {
  return html`<${WayOut} />${state.pocket && html`<${Between} /><${Nodes} /><${PlanView} />`}
    <${MemoryView} />
    <${Word} />
    <h2>${say("at_another_tag")}</h2><${Entry} />
    <p class="soft">${mission}</p><p class="soft">${say("evacuate_how")}</p><${WithoutHttps} /><${Languages} />`;
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
    onClick=${() => { speak(name); keepSpoken(); answer(); changed(); }}>${own}</button>`)}`;
}

/** The worker reads it: it knows nothing of what was chosen here. */
const keepSpoken = () => put("facts", { name: SPOKEN, value: language() }).catch(() => undefined);

/** Begin all that goes on while the page is open. */
export function start() {
  keepSpoken();
  changed();
  onReach(changed);
  watchCompass(changed);
  countSteps(changed);
  askWho();
  openOutbox();
  keepFresh();
  listenForOrders();
  onChange(() => stayAwake(target() !== null && state.route !== null));
  setInterval(changed, AGES_MS); // ages go on
  for (const shown of ["pageshow", "visibilitychange"]) addEventListener(shown, () => changed()); // they went on without it
  keepHere();
}
