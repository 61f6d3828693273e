/** The responder's phone at a tag: where am I, who is near, the way there tag by tag, and leaving word. */

import { request } from "../console/api.js";
import { html, render } from "../console/vendor.js";
import { Alarm, lookForOrders, Mayday } from "./alarm.js";
import { Doubt, Entry } from "./entry.js";
import { far, Guide } from "./guide.js";
import { lead, load, target } from "./lead.js";
import { Word } from "./report.js";
import { changed, onChange, state } from "./state.js";
import { language, say } from "./texts.js";

function Page() {
  const { where } = state;
  const trouble = html`${state.trouble && html`<p class="trouble" role="alert">${state.trouble}</p>`}<${Doubt} />`;
  if (!where) return html`<h1>${say("which_tag")}</h1>${trouble}<${Entry} />`;
  const goal = target();
  return html`<h1>${say("tag", { tag: where.tag_id })}</h1>
    ${trouble}
    ${state.said && html`<p role="status">${state.said}</p>`}
    ${goal && state.route && html`<${Guide} route=${state.route} to=${goal.to} />`}
    <p class="where">${where.text}${where.sd_m > 1 ? ` ${say("place_unsure", { far: far(where.sd_m) })}` : ""}</p>
    ${where.notice && html`<p class="trouble">${where.notice}</p>`}
    ${where.victims.length > 0 && html`<h2>${say("lead_me_to")}</h2><ul>${where.victims.map(NearVictim)}</ul>`}
    <${Word} />
    <h2>${say("at_another_tag")}</h2><${Entry} />
    <p class="soft">${where.mission_name}</p>`;
}

/** @param {import("./state.js").NearVictim} victim */
function NearVictim({ victim_id, status, reachable, distance_m }) {
  return html`<li key=${victim_id}><button type="button" disabled=${!reachable} onClick=${() => lead(`victim:${victim_id}`)}>
    <span>${say("victim", { victim: victim_id })}<span class="soft"> ${reachable ? status : say("no_way_known")}</span></span>
    <span class="far">${far(distance_m)}</span></button></li>`;
}

const [alarm, page, foot] = ["alarm", "page", "foot"].map((id) => /** @type {HTMLElement} */ (document.getElementById(id)));

onChange(() => {
  document.title = `${state.tagId ? say("tag", { tag: state.tagId }) : say("which_tag")} · Waymark`;
  render(html`<${Alarm} />`, alarm);
  render(html`<${Page} />`, page);
  render(html`<${Mayday} />`, foot);
});

addEventListener("deviceorientationabsolute", (event) => {
  const { alpha } = /** @type {DeviceOrientationEvent} */ (event);
  if (alpha === null) return;
  state.heading = (360 - alpha) % 360;
  if (state.route) changed();
});

document.documentElement.lang = language();
page.textContent = "";
changed();
load();
lookForOrders();
request("GET", "/session").then((me) => changed({ me }), () => {});
