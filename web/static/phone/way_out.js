/** The way out: to the nearest exit that somebody has marked, and to where the mission began. */

import { html } from "../console/vendor.js";
import { state } from "./state.js";
import { say } from "./texts.js";
import { lead, target } from "./touch.js";
import { routeTo } from "./where.js";
import { metres } from "./words.js";

export function WayOut() {
  const { pocket, roads, where } = state;
  if (!pocket || !roads || !where) return null;
  const ways = /** @type {const} */ (["exit", "base"]).filter((to) => target()?.to !== to)
    .map((to) => ({ to, route: routeTo(pocket, roads, where.tag_id, to) }))
    .filter(({ to, route }) => to === "exit" || route?.distance_m); // who is at the base knows it
  const isMarked = roads.notes.some(({ kind }) => kind === "exit");
  return html`${ways.some(({ to, route }) => to === "exit" && !route) && html`<p class="soft">${say(isMarked ? "no_way_out" : "no_exit")}</p>`}
    <ul>${ways.map(({ to, route }) => route && html`<li key=${to}><button type="button" onClick=${() => lead(to)}>
      <span>${say(to === "exit" ? "way_out" : "way_to_base")}</span>
      <span class="far">${route.distance_m ? metres(route.distance_m) : say("here")}</span></button></li>`)}</ul>`;
}
